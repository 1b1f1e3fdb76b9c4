// SPDX-License-Identifier: Apache-2.0
#include "covis/features/extractor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "covis/core/random.h"
#include "covis/features/fast.h"
#include "covis/features/orb.h"
#include "covis/features/pyramid.h"
#include "covis/features/test_images.h"

namespace covis {
namespace {

TEST(KeypointRoom, IsThatOfTheLevelsInsideTheirBorders) {
  const OrbOptions options;
  EXPECT_EQ(keypoint_room(options, 2 * kEdgeBorder, 480), 0);
  EXPECT_NEAR(keypoint_room(options, 160, 120), 150, 20);
  EXPECT_GT(keypoint_room(options, 320, 240), 1000);
  EXPECT_GT(keypoint_room(options, 640, 480), 5000);
}

TEST(Extractor, TheWantedNumberIsReached) {
  for (const auto& [width, height] : {std::pair{640, 480}, std::pair{1241, 376}, std::pair{320, 240}}) {
    const ImageU8 image = texture(width, height, 7);
    for (const int wanted : {300, 1000, 2000}) {
      OrbOptions options;
      options.features = wanted;
      OrbExtractor extractor(options);
      const KeyPoints& found = extractor.extract(image.view());
      size_t corners = 0;
      FastDetector detector;
      std::vector<Corner> all;
      for (int l = 0; l < 8; ++l) {
        detector.detect(extractor.level(l), kEdgeBorder, 30, 20, 7, all);
        corners += all.size();
      }
      EXPECT_GE(found.size() + 8, std::min<size_t>(static_cast<size_t>(wanted), corners)) << width << " " << wanted;
      EXPECT_LE(found.size(), static_cast<size_t>(wanted) + 3 * 8);
    }
  }
}

std::vector<int> points_of_levels(int width, int height, int budget) {
  OrbExtractor extractor{OrbOptions{}};
  extractor.set_budget(budget);
  std::vector<int> points(8);
  for (const uint8_t level : extractor.extract(texture(width, height, 7).view()).level) ++points[level];
  return points;
}

TEST(Extractor, CoarseLevelsOfSmallImagesAreNotCrowded) {
  constexpr double kScale = 1.2, kMore = 3;  // a level may exceed its share by three
  const std::vector<int> small = points_of_levels(320, 240, 1000);
  EXPECT_GE(std::accumulate(small.begin(), small.end(), 0), 1000 - 8);
  for (int l = 0; l < 8; ++l) {
    const double scale = std::pow(kScale, l), inside = (320 / scale - 37) * (240 / scale - 37);
    EXPECT_LE(small[static_cast<size_t>(l)], inside / 144 + kMore) << "level " << l;
  }
  for (const int budget : {1000, 2000}) {  // there is room for all
    const std::vector<int> large = points_of_levels(640, 480, budget);
    for (int l = 0; l < 8; ++l) {
      const double share = budget * (1 - 1 / kScale) / (1 - std::pow(kScale, -8)) * std::pow(kScale, -l);
      EXPECT_NEAR(large[static_cast<size_t>(l)], share, 1 + kMore) << budget << ", level " << l;
    }
  }
}

// Whole numbers and IEEE arithmetic alone lead to the places, so their hash is the same everywhere; angles and
// descriptors follow from them by the mathematics library's arc tangent, sine and cosine. A change of
// the first value changes every trajectory of small images (437x300 to 511x300), one of the second all.
uint64_t hash_of_places(int width, int height) {
  uint64_t hash = 14695981039346656037u;  // FNV-1a
  const auto add = [&](uint64_t value) { hash = (hash ^ value) * 1099511628211u; };
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    Random random(seed);
    ImageU8 image(width + 37 * static_cast<int>(seed), height), blurred;
    std::fill(image.row(0), image.row(height - 1) + image.stride(), uint8_t{128});
    for (int k = 0; k < width * height / 300; ++k) {
      const auto w = 3 + random.below(40), h = 3 + random.below(40),
                 x = random.below(static_cast<uint32_t>(width - 40)),
                 y = random.below(static_cast<uint32_t>(height - 50));
      const auto grey = static_cast<uint8_t>(random.below(256));
      for (uint32_t row = y; row < y + h; ++row) std::fill_n(image.row(static_cast<int>(row)) + x, w, grey);
    }
    GaussianBlur().apply(image.view(), blurred);
    OrbExtractor extractor{OrbOptions{}};
    const KeyPoints& k = extractor.extract(blurred.view());
    for (size_t i = 0; i < k.size(); ++i) {
      add(std::bit_cast<uint32_t>(k.x[i]));
      add(std::bit_cast<uint32_t>(k.y[i]));
      add(k.level[i]);
    }
    add(k.size());
  }
  return hash;
}

TEST(Extractor, PlacesAreThoseOfEver) {
  EXPECT_EQ(hash_of_places(400, 300), 2335275994541423846u);
  EXPECT_EQ(hash_of_places(640, 480), 13350604568998309186u);
}

}  // namespace
}  // namespace covis
