// SPDX-License-Identifier: Apache-2.0
// All worlds: what is in them, and that images, depth and poses agree.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "synth/test_worlds.h"

namespace covis {
namespace {

// The worlds made to fool: what looks alike is not the same place.
bool is_open(const std::string& name) { return name == "twins" || name == "posters"; }

class EveryWorld : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Worlds, EveryWorld, testing::ValuesIn(synth_worlds()),
                         [](const auto& param_info) { return param_info.param; });

TEST_P(EveryWorld, SameSeedSameBytesInAnyOrder) {
  SynthOptions options = small(GetParam());
  options.noise = 3;
  options.exposure = 0.2;
  options.blur = 10;
  options.depth_noise = 1;
  options.distortion = 0.7;
  Synth a = make(options), b = make(options);
  ImageU8 first, second, other, plain1, plain2;
  ImageF depth1, depth2;
  a.render(3, first, nullptr, &depth1);
  b.render(200, other, nullptr, nullptr);
  b.render(3, second, nullptr, &depth2);
  world(GetParam(), 1).render(3, plain1, nullptr, nullptr);
  world(GetParam(), 2).render(3, plain2, nullptr, nullptr);
  EXPECT_EQ(hash(first), hash(second));
  EXPECT_NE(hash(first), hash(other));
  EXPECT_NE(hash(plain1), hash(plain2));
  for (int y = 0; y < depth1.height(); ++y) {
    ASSERT_TRUE(std::equal(depth1.row(y), depth1.row(y) + depth1.width(), depth2.row(y))) << y;
  }
}

// A frame, moved by the truth, explains the next ones.
TEST_P(EveryWorld, DepthAndPosesExplainTheNextImage) {
  Synth& synth = world(GetParam());
  ImageU8 image1, image2;
  ImageF depth1, depth2;
  const Camera& camera = synth.camera();
  for (const int i : {0, 100, 250}) {
    const int step = GetParam() == "street" ? 1 : 4;
    synth.render(i, image1, nullptr, &depth1);
    synth.render(i + step, image2, nullptr, &depth2);
    const SE3 T_21 = synth.T_wc(i + step).inverse() * synth.T_wc(i);
    std::vector<double> tone_errors, depth_errors;
    for (int y = 0; y < camera.height; y += 2) {
      for (int x = 0; x < camera.width; x += 2) {
        if (!(depth1(x, y) > 0)) continue;
        const Eigen::Vector3d p = T_21 * (static_cast<double>(depth1(x, y)) * camera.pinhole.unproject(x, y));
        if (p.z() <= 0.05) continue;
        const Eigen::Vector2d at = camera.pinhole.project(p);
        if (!inside(camera, at)) continue;
        depth_errors.push_back(std::abs(sample(depth2, at.x(), at.y()) - p.z()) / p.z());
        tone_errors.push_back(std::abs(sample(image2, at.x(), at.y()) - image1(x, y)));
      }
    }
    ASSERT_GT(tone_errors.size(), 3000u);
    EXPECT_LT(quantile(depth_errors, 0.5), 1e-3) << i;
    EXPECT_LT(quantile(depth_errors, 0.8), 0.01) << i;
    EXPECT_LT(quantile(tone_errors, 0.5), 5) << i;
  }
}

TEST_P(EveryWorld, DisparityIsBaselineTimesFocalOverDepth) {
  Synth& synth = world(GetParam());
  ImageU8 left, right;
  ImageF depth;
  synth.render(50, left, &right, &depth);
  const Camera& camera = synth.camera();
  const double bf = camera.pinhole.fx * synth.options().baseline;
  // The right image is explained best by exactly this disparity.
  std::vector<double> errors;
  for (const double shift : {-0.3, 0.0, 0.3}) {
    double sum = 0;
    int count = 0;
    for (int y = 1; y < camera.height - 1; ++y) {
      for (int x = 1; x < camera.width - 1; ++x) {
        if (!(depth(x, y) > 0)) continue;
        const double u = x - bf / static_cast<double>(depth(x, y)) + shift;
        if (u < 1 || u > camera.width - 2) continue;
        sum += std::min(30.0, std::abs(sample(right, u, y) - left(x, y)));
        ++count;
      }
    }
    errors.push_back(sum / count);
  }
  EXPECT_LT(errors[1], 0.8 * errors[0]);
  EXPECT_LT(errors[1], 0.8 * errors[2]);
  EXPECT_LT(errors[1], 6);
}

TEST_P(EveryWorld, MovesSmoothlyAtASensibleSpeed) {
  for (const int seed : {1, 2}) {
    const Synth& synth = world(GetParam(), seed);
    const double fps = synth.options().fps;
    const bool street = GetParam() == "street";
    const double top_speed = street                     ? 10.5
                             : GetParam() == "corridor" ? 1.8
                             : is_open(GetParam())      ? 1.2
                                                        : 1.0,
                 top_turn = (street ? 40 : 50) * std::numbers::pi / 180;
    Eigen::Vector3d last_velocity(0, 0, 0), last_turn(0, 0, 0);
    double mean_speed = 0;
    for (int i = 0; i + 1 < synth.frames(); ++i) {
      const SE3 a = synth.T_wc(i), b = synth.T_wc(i + 1);
      const Eigen::Vector3d velocity = fps * (b.t() - a.t());
      const Eigen::AngleAxisd angle(a.R().transpose() * b.R());
      const Eigen::Vector3d turn = fps * angle.angle() * angle.axis();
      EXPECT_TRUE((a.R() * a.R().transpose()).isIdentity(1e-9) && a.R().determinant() > 0);
      ASSERT_LT(velocity.norm(), top_speed) << i;
      ASSERT_LT(turn.norm(), top_turn) << i;
      if (i > 0) {  // motion does not jump
        ASSERT_LT(fps * (velocity - last_velocity).norm(), street ? 8 : 3) << i;
        ASSERT_LT(fps * (turn - last_turn).norm(), 3) << i;
      }
      if (i == 0) {
        EXPECT_GT(velocity.norm(), 0.1) << "a monocular start needs parallax";
      }
      last_velocity = velocity;
      last_turn = turn;
      mean_speed += velocity.norm() / (synth.frames() - 1);
    }
    EXPECT_GT(mean_speed, street ? 6 : GetParam() == "corridor" ? 0.9 : 0.25);
  }
}

TEST_P(EveryWorld, ComesBackToItsBeginningOrNeverWill) {
  const Synth& synth = world(GetParam());
  const SE3 start = synth.T_wc(0);
  if (is_open(GetParam())) {
    double length = 0;
    for (int i = 0; i + 30 < synth.frames(); i += 30) {
      const Eigen::Vector3d a = synth.T_wc(i).t(), b = synth.T_wc(i + 30).t();
      EXPECT_GT(b.x(), a.x() + 0.3) << "going on in every second, here after frame " << i;
      length += (b - a).norm();
    }
    EXPECT_GT(length, 14);
    EXPECT_LT(length, 40);
    EXPECT_GE(synth.frames(), 400);
    EXPECT_LE(synth.frames(), 960);
    return;
  }
  double nearest = 1e9, farthest = 0;
  for (int i = 0; i < synth.frames(); ++i) {
    const SE3 pose = synth.T_wc(i);
    farthest = std::max(farthest, (pose.t() - start.t()).norm());
    const double turned = Eigen::AngleAxisd(pose.R().transpose() * start.R()).angle();
    if (i > synth.frames() * 3 / 4) nearest = std::min(nearest, (pose.t() - start.t()).norm() + turned);
  }
  EXPECT_LT(nearest, GetParam() == "street" ? 1.2 : 0.25);
  const double least_extent = GetParam() == "street"     ? 60
                              : GetParam() == "corridor" ? 15
                              : GetParam() == "room"     ? 2
                                                         : 0.5;
  EXPECT_GT(farthest, least_extent);
}

TEST_P(EveryWorld, IsClosedAndNotFlat) {
  for (const int seed : {1, 2}) {
    Synth& synth = world(GetParam(), seed);
    ImageU8 image;
    ImageF depth;
    for (int k = 0; k < 8; ++k) {
      const int i = k * synth.frames() / 8;
      synth.render(i, image, nullptr, &depth);
      int empty = 0;
      std::vector<double> depths, tones;
      for (int y = 0; y < depth.height(); ++y) {
        for (int x = 0; x < depth.width(); ++x) {
          empty += depth(x, y) <= 0;
          if (depth(x, y) > 0) depths.push_back(static_cast<double>(depth(x, y)));
          tones.push_back(image(x, y));
        }
      }
      if (GetParam() == "street") {
        EXPECT_LT(empty, depth.width() * depth.height() / 2) << "sky in frame " << i;
      } else {
        EXPECT_EQ(empty, 0) << "frame " << i;
      }
      EXPECT_GT(quantile(depths, 0.9) / quantile(depths, 0.1), 1.1) << "frame " << i;
      EXPECT_GT(quantile(tones, 0.9) - quantile(tones, 0.1), 30) << "frame " << i;
      EXPECT_GT(quantile(depths, 0), 0.15) << "the camera is inside something in frame " << i;
    }
  }
}

TEST(FoolingWorlds, OpenPathsEndAtRestInsideTheirWorld) {
  for (const char* name : {"twins", "posters"}) {
    SynthOptions options = small(name);
    Synth& plain = world(name);
    options.frames = 2 * plain.frames();
    Synth longer = make(options);
    EXPECT_LT((longer.T_wc(2 * plain.frames() - 1).t() - longer.T_wc(plain.frames()).t()).norm(), 0.5) << name;
    ImageU8 image;
    ImageF depth;
    longer.render(2 * plain.frames() - 1, image, nullptr, &depth);
    for (int y = 0; y < depth.height(); ++y) {
      ASSERT_GT(*std::min_element(depth.row(y), depth.row(y) + depth.width()), 0.15f) << name;
    }
  }
}

}  // namespace
}  // namespace covis
