// SPDX-License-Identifier: Apache-2.0
// The needs of a tracker: as many keypoints as it asks for, spread over the image, and found again in the next frames
// where the truth says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "covis/features/extractor.h"
#include "synth/test_worlds.h"

namespace covis {
namespace {

constexpr int kWidth = 640, kHeight = 480, kCell = 80;

int cells_with_keypoints(const KeyPoints& points) {
  std::vector<int> cells(kWidth / kCell * kHeight / kCell, 0);
  for (size_t k = 0; k < points.size(); ++k) {
    ++cells[static_cast<size_t>(points.y[k] / kCell) * (kWidth / kCell) + static_cast<size_t>(points.x[k] / kCell)];
  }
  return static_cast<int>(std::count_if(cells.begin(), cells.end(), [](int n) { return n > 0; }));
}

// The keypoint most like the wanted one within four pixels of where it should be: how far off it is, if it is alike
// enough to be the same. Pixels are those of the wanted one's level.
std::optional<double> found_near(const Eigen::Vector2d& at, const Descriptor& wanted, double scale,
                                 const KeyPoints& points) {
  int best = 60;  // bits
  std::optional<double> found;
  for (size_t m = 0; m < points.size(); ++m) {
    const double distance = std::hypot(points.x[m] - at.x(), points.y[m] - at.y()) / scale;
    if (distance > 4) continue;
    const int bits = hamming(wanted, points.descriptor[m]);
    if (bits < best) {
      best = bits;
      found = distance;
    }
  }
  return found;
}

class KeyPointsOfWorld : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Worlds, KeyPointsOfWorld, testing::ValuesIn(synth_worlds()),
                         [](const auto& param_info) { return param_info.param; });

TEST_P(KeyPointsOfWorld, AreManyAndFoundAgain) {
  SynthOptions options = small(GetParam());
  options.width = kWidth;
  options.height = kHeight;
  Synth synth = make(options);
  OrbOptions orb;
  orb.features = 1000;
  OrbExtractor extractor1(orb), extractor2(orb);
  const Camera& camera = synth.camera();
  const int step = GetParam() == "street" ? 1 : 3;
  ImageU8 image1, image2;
  ImageF depth1;
  size_t total = 0, expected = 0;
  std::vector<double> errors;
  for (const int i : {10, 130, 250, 370}) {
    synth.render(i, image1, nullptr, &depth1);
    synth.render(i + step, image2, nullptr, nullptr);
    const SE3 T_21 = synth.T_wc(i + step).inverse() * synth.T_wc(i);
    const KeyPoints& a = extractor1.extract(image1.view());
    const KeyPoints& b = extractor2.extract(image2.view());
    EXPECT_GE(a.size(), 950u) << i;
    EXPECT_GE(cells_with_keypoints(a), 36) << i;
    total += a.size();
    for (size_t k = 0; k < a.size(); ++k) {
      const float z = depth1(static_cast<int>(std::lround(a.x[k])), static_cast<int>(std::lround(a.y[k])));
      if (!(z > 0)) continue;
      const Eigen::Vector3d p = T_21 * (static_cast<double>(z) * camera.pinhole.unproject(a.x[k], a.y[k]));
      if (p.z() < 0.1) continue;
      const Eigen::Vector2d at = camera.pinhole.project(p);
      if (at.x() < 25 || at.y() < 25 || at.x() > kWidth - 25 || at.y() > kHeight - 25) continue;
      ++expected;
      if (const auto error = found_near(at, a.descriptor[k], std::pow(1.2, a.level[k]), b)) errors.push_back(*error);
    }
  }
  EXPECT_GT(expected, total / 2);
  // Real recordings reach about 55 % at this distance.
  EXPECT_GT(static_cast<double>(errors.size()), 0.45 * static_cast<double>(expected));
  EXPECT_LT(quantile(errors, 0.5), 0.8);
}

}  // namespace
}  // namespace covis
