// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/depth_noise_tracker.h"

#include <gtest/gtest.h>

#include "covis/core/random.h"
#include "covis/optimization/depth_noise_estimation.h"

namespace covis {
namespace {

// Three cameras at one place and points whose depths have this noise.
BundleProblem problem_with(const DepthNoise& noise, const Pinhole& camera, uint64_t seed) {
  Random random(seed);
  BundleProblem problem;
  problem.camera = camera;
  problem.poses.assign(3, SE3());
  problem.fixed.assign(3, 1);
  for (int p = 0; p < 400; ++p) {
    const double z = random.uniform(1, 5);
    double mean = 0;
    for (int c = 0; c < 3; ++c) {
      const auto depth = static_cast<float>(z + noise.sigma(z) * random.normal());
      mean += static_cast<double>(depth) / 3;
      problem.observations.push_back(
          {.pose = c, .point = p, .inv_sigma2 = 1000, .disparity = disparity_of_depth(camera, depth, 1000)});
    }
    problem.points.emplace_back(0, 0, mean);
  }
  return problem;
}

void learn_of(SharedMap& map, const DepthNoise& noise) {
  DepthNoiseTracker tracker;
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    const Pinhole camera = map.read()->camera();
    tracker.learn(map, problem_with(noise, camera, seed));
  }
}

TEST(DepthNoiseTracker, TheMapsCameraGetsTheNoiseOfTheSensor) {
  for (const double factor : {0.2, 2.5}) {
    Pinhole camera{500, 500, 320, 240, 40};
    camera.depth_noise = DepthNoise::kinect();
    SharedMap map(camera);
    const uint64_t moves = map.read()->moves();
    learn_of(map, DepthNoise::kinect().scaled(factor));
    EXPECT_EQ(map.read()->moves(), moves) << "no pose and no point moves";
    EXPECT_NEAR(map.read()->camera().depth_noise.b, factor * DepthNoise::kinect().b, 0.15 * factor * 0.0015);
    EXPECT_EQ(map.read()->camera().bf, 40);
  }
}

// Another adjustment changed the noise: bounds are still those of the noise that the map began with.
TEST(DepthNoiseTracker, ItGoesOnFromWhatTheNoiseIs) {
  Pinhole camera{500, 500, 320, 240, 40};
  camera.depth_noise = DepthNoise::kinect();
  SharedMap map(camera);
  DepthNoiseTracker tracker;
  const auto learn = [&](double factor, uint64_t seed) {
    const Pinhole now = map.read()->camera();
    tracker.learn(map, problem_with(DepthNoise::kinect().scaled(factor), now, seed));
  };
  learn(1, 1);
  camera.depth_noise = DepthNoise::kinect().scaled(0.01);
  map.write()->set_camera(camera);
  learn(0.01, 2);
  EXPECT_NEAR(map.read()->camera().depth_noise.b, 0.0015 / 16, 1e-9) << "the least there is";
  for (uint64_t seed = 3; seed <= 150; ++seed) learn(2, seed);
  EXPECT_NEAR(map.read()->camera().depth_noise.b, 2 * 0.0015, 0.0006);
}

// Each run that continues a map begins with what the last one found: five of them came to 1/1890 of a Kinect's noise.
TEST(DepthNoiseTracker, BoundsAreThoseOfAKinectHoweverOftenAMapIsContinued) {
  Pinhole camera{500, 500, 320, 240, 40};
  camera.depth_noise = DepthNoise::kinect();
  SharedMap map(camera);
  for (int run = 0; run < 3; ++run) learn_of(map, DepthNoise::kinect().scaled(0.001));
  EXPECT_NEAR(map.read()->camera().depth_noise.b, 0.0015 / 16, 1e-9);
}

TEST(DepthNoiseTracker, ItStaysWithinItsBounds) {
  Pinhole camera{500, 500, 320, 240, 40};
  camera.depth_noise = DepthNoise::kinect();
  SharedMap map(camera);
  learn_of(map, DepthNoise::kinect().scaled(30));
  EXPECT_NEAR(map.read()->camera().depth_noise.b, 4 * 0.0015, 1e-9);
}

}  // namespace
}  // namespace covis
