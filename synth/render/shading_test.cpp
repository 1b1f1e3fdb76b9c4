// SPDX-License-Identifier: Apache-2.0
#include "synth/render/shading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "covis/core/random.h"
#include "covis/core/test_targets.h"
#include "synth/test_worlds.h"

namespace covis {
namespace {

TEST(Synth, EverySimdTargetGivesTheSameBytes) {
  Synth& painted = world("street");
  SynthOptions options = small("desk");
  options.light = 1;
  Synth lit = make(options);
  std::vector<std::pair<uint64_t, std::vector<float>>> rendered;
  for_each_target([&] {
    ImageU8 image;
    ImageF depth;
    lit.render(11, image, nullptr, nullptr);
    const uint64_t lit_hash = hash(image);
    painted.render(11, image, nullptr, &depth);
    std::vector<float> depths;
    for (int y = 0; y < depth.height(); ++y) depths.insert(depths.end(), depth.row(y), depth.row(y) + depth.width());
    rendered.emplace_back(hash(image) ^ lit_hash, std::move(depths));
    EXPECT_EQ(rendered.back().first, rendered[0].first);
    EXPECT_TRUE(rendered.back().second == rendered[0].second);
  });
}

TEST(Shading, ASpanTakesWhatIsNearer) {
  Random random(1);
  for_each_target([&] {
    for (int count = 1; count < 40; ++count) {
      std::vector<float> z(static_cast<size_t>(count + synth::kShadeOverrun), 0.5f);
      std::vector<uint32_t> id(z.size(), 7);
      const float w_0 = static_cast<float>(random.uniform(0, 1)), w_x = static_cast<float>(random.uniform(-0.05, 0.05));
      synth::fill_span(w_0, w_x, 9, count, z.data(), id.data());
      for (int i = 0; i < count; ++i) {
        const auto k = static_cast<size_t>(i);
        const float w = w_0 + static_cast<float>(i) * w_x;
        if (std::abs(w - 0.5f) < 1e-5f) continue;  // rounding decides there
        EXPECT_EQ(id[k], w > 0.5f ? 9u : 7u);
        EXPECT_NEAR(z[k], std::max(w, 0.5f), 1e-6f);
      }
    }
  });
}

TEST(Shading, TheMeanAlongNoStepIsThePixel) {
  ImageF image(40, 5);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 40; ++x) image(x, y) = static_cast<float>(10 * y + x);
  }
  const size_t size = 40 + synth::kShadeOverrun;
  const std::vector<float> none(size, 0.0f), three(size, 3.0f), one(size, 1.0f);
  std::vector<float> mean(size);
  for_each_target([&] {
    synth::mean_along_steps(std::as_const(image).view(), 2, none.data(), none.data(), one.data(), 40, mean.data());
    for (int x = 0; x < 40; ++x) EXPECT_NEAR(mean[static_cast<size_t>(x)], image(x, 2), 2e-3f);
    // Three look-ups a pixel apart: the same on a ramp, but at its ends, where the edge repeats.
    synth::mean_along_steps(std::as_const(image).view(), 2, one.data(), none.data(), three.data(), 40, mean.data());
    for (int x = 1; x < 39; ++x) EXPECT_NEAR(mean[static_cast<size_t>(x)], image(x, 2), 2e-3f);
    EXPECT_GT(mean[0], image(0, 2));
  });
}

}  // namespace
}  // namespace covis
