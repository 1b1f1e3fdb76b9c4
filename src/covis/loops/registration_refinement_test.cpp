// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/registration_refinement.h"

#include <gtest/gtest.h>

#include "covis/loops/test_depth_scene.h"

namespace covis {
namespace {

constexpr DepthRegistration kDepthTruth{.scale = 1.1, .shift_x = 3, .shift_y = -2};
constexpr size_t kKeyFrames = 12;

// A map whose key frames looked their depths up where the images show the points.
struct RegistrationRefinementTest : testing::Test {
  explicit RegistrationRefinementTest(const DepthRegistration& registration = kDepthTruth) : world(registration) {
    map.add_key_frames(kKeyFrames);
    for (size_t k = 0; k < kKeyFrames; ++k) keep(k);
  }
  void keep(size_t k) {
    auto features = std::make_shared<Features>(*map.views[k].features);
    world.depth(k)->look_up(world.scene.camera, *features);
    map.shared.write()->set_features(map.frames[k], features);
  }
  std::unique_ptr<RegistrationRefinement> job(bool noise = true) {
    return RegistrationRefinement::of(*map.shared.read(), map.frames.back(), {world.scene.camera.fx, noise});
  }
  // The median share by which depths of key frames are off.
  double error() {
    std::vector<double> errors;
    for (size_t k = 0; k < map.frames.size(); ++k) {
      const FeaturesPtr now = map.shared.read()->at(map.frames[k]).features, &truth = map.views[k].features;
      for (size_t i = 0; i < now->depth.size(); ++i)
        if (now->depth[i] > 0) errors.push_back(std::abs(static_cast<double>(now->depth[i] / truth->depth[i]) - 1));
    }
    std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
    return errors[errors.size() / 2];
  }

  DepthScene world;
  SceneMap map{world.scene};
  std::atomic<bool> interrupt{false};
};

TEST_F(RegistrationRefinementTest, DepthsAreThoseOfTheirPoints) {
  const double before = error();
  const auto asked = job();
  ASSERT_TRUE(asked->run(interrupt));
  ASSERT_TRUE(asked->apply(map.shared));
  const Pinhole camera = map.shared.read()->camera();
  EXPECT_NEAR(camera.registration.scale, kDepthTruth.scale, 0.01);
  EXPECT_LT(error(), before / 8);
  EXPECT_EQ(camera.fx, world.scene.camera.fx);
  EXPECT_LT(camera.depth_noise.a, DepthNoise::kinect().a) << "these depths are exact";
  EXPECT_EQ(map.shared.read()->check(), "");
}

TEST_F(RegistrationRefinementTest, NoiseThatWasGivenStays) {
  const auto asked = job(false);
  ASSERT_TRUE(asked->run(interrupt));
  ASSERT_TRUE(asked->apply(map.shared));
  EXPECT_EQ(map.shared.read()->camera().depth_noise, DepthNoise::kinect());
}

// Wrong depths said that the focal length was another one; that is forgotten.
TEST_F(RegistrationRefinementTest, TheFocalLengthIsTheOneGiven) {
  Pinhole refined = world.scene.camera;
  refined.fx *= 1.02;
  refined.fy *= 1.02;
  map.shared.write()->set_camera(refined);
  const auto asked = job();
  ASSERT_TRUE(asked->run(interrupt));
  ASSERT_TRUE(asked->apply(map.shared));
  EXPECT_EQ(map.shared.read()->camera().fx, world.scene.camera.fx);
  EXPECT_NEAR(map.shared.read()->camera().fy, world.scene.camera.fy, 1e-9);
}

// Key frames that came while the job ran, with the depths they had then.
TEST_F(RegistrationRefinementTest, KeyFramesThatCameMeanwhileAreLookedUpToo) {
  const auto asked = job();
  ASSERT_TRUE(asked->run(interrupt));
  map.add(world.scene.T_cw(kKeyFrames));
  keep(kKeyFrames);
  ASSERT_TRUE(asked->apply(map.shared));
  for (const KeyFrameId& id : map.frames) {
    const auto now = map.shared.read();
    EXPECT_EQ(now->at(id).features->kept_depth->looked_up_by(), now->camera().registration);
  }
}

TEST_F(RegistrationRefinementTest, NothingIsDoneWhereDepthsAreNotKept) {
  const auto asked = job();
  ASSERT_TRUE(asked->run(interrupt));
  map.add(world.scene.T_cw(kKeyFrames));
  EXPECT_FALSE(asked->apply(map.shared));
  EXPECT_FALSE(map.shared.read()->camera().registration.any());
}

TEST_F(RegistrationRefinementTest, EndsWhenInterrupted) {
  interrupt = true;
  EXPECT_FALSE(job()->run(interrupt));
}

struct RegisteredDepth : RegistrationRefinementTest {
  RegisteredDepth() : RegistrationRefinementTest(DepthRegistration{}) {}
};

TEST_F(RegisteredDepth, IsLeftAlone) { EXPECT_FALSE(job()->run(interrupt)); }

TEST_F(RegisteredDepth, TheMapIsAskedAFewTimesWhileItIsSmall) {
  RegistrationSchedule schedule;
  EXPECT_TRUE(schedule.ask(*map.shared.read()));
  EXPECT_FALSE(schedule.ask(*map.shared.read())) << "not twice at once";
  int asked = 1;
  while (RegistrationSchedule::keeps_depths(*map.shared.read())) {
    map.add(world.scene.T_cw(map.frames.size()));
    auto features = std::make_shared<Features>(*map.views.back().features);
    features->kept_depth = map.shared.read()->at(map.frames.front()).features->kept_depth;
    map.shared.write()->set_features(map.frames.back(), features);
    asked += schedule.ask(*map.shared.read());
  }
  EXPECT_GE(asked, 2);
  EXPECT_LE(asked, 5);
  RegistrationSchedule::drop_depths(map.shared);
  for (const KeyFrameId& id : map.frames) EXPECT_FALSE(map.shared.read()->at(id).features->kept_depth);
}

TEST_F(RegisteredDepth, AMapThatHasARegistrationIsNotAsked) {
  Pinhole camera = world.scene.camera;
  camera.registration = kDepthTruth;
  map.shared.write()->set_camera(camera);
  EXPECT_FALSE(RegistrationSchedule().ask(*map.shared.read()));
}

TEST_F(RegisteredDepth, AMapWithDepthsThatCantBeLookedUpIsNotAsked) {
  map.add(world.scene.T_cw(kKeyFrames));
  EXPECT_FALSE(RegistrationSchedule().ask(*map.shared.read()));
}

}  // namespace
}  // namespace covis
