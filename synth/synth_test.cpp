// SPDX-License-Identifier: Apache-2.0
#include "synth/synth.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "synth/test_worlds.h"

namespace covis {
namespace {

using ::testing::HasSubstr;

TEST(Synth, DistortedImagesFollowTheCameraModel) {
  SynthOptions options = small("room", "rgbd");
  options.width = 640;
  options.height = 480;
  Synth straight = make(options);
  options.distortion = 1;
  Synth bent = make(options);
  const Camera& camera = bent.camera();
  ASSERT_EQ(camera.distortion, Distortion::brown_conrady);
  ImageU8 image, bent_image;
  ImageF depth, bent_depth;
  straight.render(20, image, nullptr, &depth);
  bent.render(20, bent_image, nullptr, &bent_depth);
  // Points known from the undistorted frame land where the model says, with their depth and look.
  std::vector<double> tone_errors, depth_errors, unbent_errors;
  double farthest = 0;
  for (int y = 2; y < camera.height - 2; y += 2) {
    for (int x = 2; x < camera.width - 2; x += 2) {
      const Eigen::Vector3d p = static_cast<double>(depth(x, y)) * straight.camera().pinhole.unproject(x, y);
      const auto at = camera.project(p);
      if (!at || !inside(camera, *at)) continue;
      farthest = std::max(farthest, (*at - Eigen::Vector2d(x, y)).norm());
      depth_errors.push_back(std::abs(sample(bent_depth, at->x(), at->y()) - p.z()) / p.z());
      tone_errors.push_back(std::abs(sample(bent_image, at->x(), at->y()) - image(x, y)));
      unbent_errors.push_back(std::abs(static_cast<double>(bent_image(x, y)) - image(x, y)));
    }
  }
  EXPECT_GT(farthest, 30);
  EXPECT_LT(quantile(depth_errors, 0.5), 1e-4);
  EXPECT_LT(quantile(depth_errors, 0.9), 0.01);
  EXPECT_LT(quantile(tone_errors, 0.5), 2.5);
  EXPECT_LT(quantile(tone_errors, 0.5), 0.4 * quantile(unbent_errors, 0.5));
}

TEST(Synth, TheStreetsWayCanBeLonger) {
  SynthOptions options = small("street");
  options.way = 500;
  const Synth longer = make(options);
  EXPECT_GT(longer.frames(), 1.3 * world("street").frames());
  double metres = 0;  // once around
  for (int i = 1; i < longer.frames(); ++i) metres += (longer.T_wc(i).t() - longer.T_wc(i - 1).t()).norm();
  EXPECT_NEAR(metres, 500, 50);
  options.world = "room";
  EXPECT_FALSE(Synth::create(options).has_value());
}

TEST(Synth, AnotherLightIsOverTheSamePlace) {
  SynthOptions options = small("desk");
  options.light = 1;
  Synth lit = make(options);
  Synth& painted = world("desk");
  ImageU8 image, lit_image;
  ImageF depth, lit_depth;
  painted.render(20, image, nullptr, &depth);
  lit.render(20, lit_image, nullptr, &lit_depth);
  std::vector<double> ratios;
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      ASSERT_EQ(depth(x, y), lit_depth(x, y));
      if (depth(x, y) > 0) ratios.push_back((lit_image(x, y) + 1.0) / (image(x, y) + 1.0));
    }
  }
  EXPECT_NEAR(quantile(ratios, 0.5), 1, 0.35) << "the exposure is right";
  EXPECT_GT(quantile(ratios, 0.95), 1.25 * quantile(ratios, 0.05)) << "not all is lit alike";
  const uint64_t first = hash(lit_image);
  make(options).render(20, lit_image, nullptr, nullptr);
  EXPECT_EQ(hash(lit_image), first);
  options.light = 2;
  make(options).render(20, lit_image, nullptr, nullptr);
  EXPECT_NE(hash(lit_image), first);
}

// Things that move hide some of the world and change nothing else.
TEST(Synth, ThingsMoveBeforeTheSamePlace) {
  for (const char* name : {"room", "desk", "corridor", "street"}) {
    SynthOptions options = small(name);
    options.moving = 3;
    Synth busy = make(options);
    Synth& empty = world(name);
    ImageU8 image, busy_image;
    ImageF depth, busy_depth;
    int hidden = 0, farther = 0;
    for (const int i : {60, 20}) {
      empty.render(i, image, nullptr, &depth);
      busy.render(i, busy_image, nullptr, &busy_depth);
      for (int y = 0; y < depth.height(); ++y) {
        for (int x = 0; x < depth.width(); ++x) {
          hidden += busy_depth(x, y) > 0 && (depth(x, y) == 0 || busy_depth(x, y) < 0.99f * depth(x, y));
          farther += depth(x, y) > 0 && busy_depth(x, y) > depth(x, y);
        }
      }
    }
    EXPECT_EQ(farther, 0) << name;
    EXPECT_GT(hidden, 0.01 * 2 * 320 * 240) << name;
    EXPECT_LT(hidden, 0.6 * 2 * 320 * 240) << name;
    busy.render(60, image, nullptr, nullptr);
    busy.render(20, image, nullptr, nullptr);
    EXPECT_EQ(hash(image), hash(busy_image)) << name << ": in any order";
  }
}

// The right camera looks down: it shows things higher up, and the left one as before.
TEST(Synth, TheRightCameraCanBeTurned) {
  SynthOptions options;
  options.sensor = "stereo";
  auto straight = Synth::create(options).value();
  constexpr int kRows = 4;
  options.right_pitch = std::atan(kRows / straight.camera().pinhole.fy) * 180 / std::numbers::pi;
  auto turned = Synth::create(options).value();
  ImageU8 left, right, left_turned, right_turned;
  straight.render(0, left, &right, nullptr);
  turned.render(0, left_turned, &right_turned, nullptr);
  const auto difference = [](const ImageU8& a, const ImageU8& b, int rows) {
    int sum = 0;
    for (int y = 200; y < 280; ++y)
      for (int x = 280; x < 360; ++x) sum += std::abs(a(x, y) - b(x, y + rows));
    return sum / (80.0 * 80.0);
  };
  EXPECT_EQ(difference(left_turned, left, 0), 0);
  EXPECT_LT(difference(right_turned, right, kRows), 0.3 * difference(right_turned, right, -kRows));
}

TEST(Synth, StampsAndDefaults) {
  const Synth room = make(SynthOptions{});
  EXPECT_EQ(room.camera().width, 640);
  EXPECT_EQ(room.camera().height, 480);
  EXPECT_DOUBLE_EQ(room.camera().pinhole.fx, 500);
  EXPECT_DOUBLE_EQ(room.camera().pinhole.cx, 319.5);
  EXPECT_EQ(room.frames(), 600);
  EXPECT_EQ(room.stamp(0), 0);
  EXPECT_EQ(room.stamp(1), 33333000);
  EXPECT_EQ(room.sensor(), Sensor::rgbd);
  EXPECT_NEAR(room.camera().pinhole.baseline(), 0.08, 1e-12);
  EXPECT_EQ(make(small("desk", "mono")).camera().pinhole.bf, 0);
  const Synth street = make(small("street", "stereo"));
  EXPECT_EQ(street.options().fps, 10);
  EXPECT_NEAR(street.camera().pinhole.baseline(), 0.54, 1e-12);
  EXPECT_GT(street.frames(), 380);
  EXPECT_NEAR(world("street").camera().pinhole.baseline(), 0.54, 1e-12);
}

TEST(Synth, SaysWhatIsWrongWithTheOptions) {
  const auto message = [](auto change) {
    SynthOptions options;
    change(options);
    const auto synth = Synth::create(options);
    return synth ? std::string("accepted") : synth.error().message;
  };
  EXPECT_THAT(message([](auto& o) { o.world = "rom"; }), HasSubstr("did you mean 'room'"));
  EXPECT_THAT(message([](auto& o) { o.sensor = "setreo"; }), HasSubstr("did you mean 'stereo'"));
  EXPECT_THAT(message([](auto& o) { o.width = 10; }), HasSubstr("synth.width"));
  EXPECT_THAT(message([](auto& o) { o.noise = -1; }), HasSubstr("synth.noise"));
  EXPECT_THAT(message([](auto& o) { o.noise = std::nan(""); }), HasSubstr("synth.noise"));
  EXPECT_THAT(message([](auto& o) { o.light = -1; }), HasSubstr("synth.light"));
  EXPECT_THAT(message([](auto& o) { o.frames = -5; }), HasSubstr("synth.frames"));
  EXPECT_THAT(message([](auto& o) { o.moving = -1; }), HasSubstr("synth.moving"));
  EXPECT_THAT(message([](auto& o) {
                o.sensor = "stereo";
                o.distortion = 1;
              }),
              HasSubstr("rectified"));
}

}  // namespace
}  // namespace covis
