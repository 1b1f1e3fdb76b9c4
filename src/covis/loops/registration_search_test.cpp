// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/registration_search.h"

#include <gtest/gtest.h>

#include "covis/core/random.h"
#include "covis/loops/test_depth_scene.h"

namespace covis {
namespace {

const Eigen::Vector2d kCentre(160, 120);
constexpr double kShare = 0.88;
constexpr double kUnit = 1.02;  // metres of places in those of depths: no map knows it better

// The points of all views of a scene, each off by some share of its depth.
struct Sights {
  std::vector<std::shared_ptr<const KeptDepth>> depths;
  std::vector<DepthSight> all;

  explicit Sights(const DepthRegistration& registration, double noise = 0.01) {
    const DepthScene world(registration, 8);
    Random random(3);
    for (size_t i = 0; i < world.scene.T_wc.size(); ++i) {
      depths.push_back(world.depth(i));
      const PointScene::View view = world.scene.view(world.scene.T_cw(i));
      for (size_t k = 0; k < view.point.size(); ++k) {
        const Features& f = *view.features;
        const double z = f.depth[k] * (1 + noise * random.normal());
        const Eigen::Vector2f pixel(f.x[k], f.y[k]);
        all.push_back({depths.back().get(), pixel, pixel, static_cast<float>(kUnit * z), static_cast<int>(i)});
      }
    }
  }
};

// The mean distance between the places of two registrations, pixels.
double off(const Sights& sights, const DepthRegistration& a, const DepthRegistration& b) {
  double sum = 0;
  for (const DepthSight& s : sights.all) {
    const double inverse_z = 1 / static_cast<double>(s.z);
    const Eigen::Vector2d pixel = s.pixel.cast<double>();
    sum += (a.pixel(pixel, kCentre, inverse_z) - b.pixel(pixel, kCentre, inverse_z)).norm();
  }
  return sum / static_cast<double>(sights.all.size());
}

TEST(RegistrationSearch, FindsWhereDepthIs) {
  for (const DepthRegistration& truth :
       {DepthRegistration{.scale = 1.11}, DepthRegistration{.shift_x = 9, .shift_y = -5},
        DepthRegistration{.scale = 0.94, .shift_x = -4, .parallax_x = 25},
        DepthRegistration{.scale = 1.06, .parallax_y = -30}}) {
    const Sights sights(truth);
    ASSERT_GT(sights.all.size(), 1500U);
    const auto found = find_registration(sights.all, {}, kCentre, kShare);
    ASSERT_TRUE(found) << description(truth);
    EXPECT_LT(off(sights, *found, truth), 2) << description(*found) << " instead of " << description(truth);
    EXPECT_LT(fit_of(sights.all, *found, kCentre).error, 1.1 * fit_of(sights.all, truth, kCentre).error);
  }
}

TEST(RegistrationSearch, WhatIsRightStays) {
  const DepthRegistration truth{.scale = 1.08, .shift_x = 5, .parallax_x = 12};
  for (const double noise : {0.0, 0.01, 0.05}) {
    EXPECT_FALSE(find_registration(Sights({}, noise).all, {}, kCentre, kShare)) << noise;
    EXPECT_FALSE(find_registration(Sights(truth, noise).all, truth, kCentre, kShare)) << noise;
  }
}

TEST(RegistrationSearch, FewPointsTellNothing) {
  Sights sights({.scale = 1.11});
  sights.all.resize(500);
  EXPECT_FALSE(find_registration(sights.all, {}, kCentre, kShare));
  EXPECT_FALSE(find_registration({}, {}, kCentre, kShare));
  EXPECT_EQ(fit_of({}, {}, kCentre).measured, 0);
}

// Depth that is nonsense fits nowhere.
TEST(RegistrationSearch, NonsenseHasNoPlace) {
  Sights sights({.scale = 1.11});
  Random random(5);
  for (DepthSight& sight : sights.all) sight.z = static_cast<float>(random.uniform(1, 8));
  EXPECT_FALSE(find_registration(sights.all, {}, kCentre, kShare));
}

TEST(RegistrationSearch, OneViewAloneIsNotBelieved) {
  Sights sights({.scale = 1.11});
  for (DepthSight& sight : sights.all) sight.view = 4;
  EXPECT_FALSE(find_registration(sights.all, {}, kCentre, kShare)) << "there is no other half";
}

}  // namespace
}  // namespace covis
