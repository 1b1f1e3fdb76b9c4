// SPDX-License-Identifier: Apache-2.0
#include "synth/things/moving_things.h"

#include <gtest/gtest.h>

#include "synth/things/test_things.h"

namespace covis::synth {
namespace {

// A walk along x at 1 m/s, 1.5 m above the floor.
CameraPath straight_walk() {
  std::vector<CameraPose> control;
  for (int i = 0; i < 40; ++i) control.push_back({.position = {1.0 * i, 0, 1.5}});
  return {std::move(control), 1, {}, 1};
}

// The middle of a thing at a time.
Eigen::Vector3d middle(Traffic traffic, double seconds) {
  Scene scene(5);
  const MovingThings things(scene, traffic, 1, 7);
  EXPECT_TRUE(scene.polygons.empty());
  things.place(straight_walk(), seconds, scene);
  expect_sound(scene);
  const size_t polygons = scene.polygons.size();
  things.place(straight_walk(), seconds, scene);
  EXPECT_EQ(scene.polygons.size(), polygons) << "moved, not added once more";
  return extent(scene).center();
}

TEST(MovingThings, GoBeforeTheCamera) {
  for (const double seconds : {5.0, 9.0}) {
    const double camera = 1 + seconds;  // an open path begins at its second control point
    EXPECT_NEAR(middle(Traffic::people_around, seconds).x(), camera + 1, 1);
    EXPECT_NEAR(middle(Traffic::people_along, seconds).x(), camera + 1.6, 0.3);
    EXPECT_NEAR(middle(Traffic::cars, seconds).x(), camera + 1.7, 0.8);
    EXPECT_NEAR(middle(Traffic::hands, seconds).x(), camera + 0.5, 0.15);
    EXPECT_NEAR(middle(Traffic::people_along, seconds).z(), 0.87, 0.15) << "on the floor";
    EXPECT_NEAR(middle(Traffic::hands, seconds).z(), 1.36, 0.05) << "in somebody's hands";
  }
}

TEST(MovingThings, EverySecondOneOnTheWayComesTowardsTheCamera) {
  Scene scene(5);
  const MovingThings both(scene, Traffic::cars, 2, 7);
  const auto in_the_other_lane = [&](double seconds) {
    both.place(straight_walk(), seconds, scene);
    Eigen::AlignedBox3d box;
    for (const Vector3d& v : scene.vertices) {
      if (v.y() > 1.6) box.extend(v);
    }
    return box;
  };
  const Eigen::AlignedBox3d before = in_the_other_lane(2), after = in_the_other_lane(5);
  ASSERT_FALSE(before.isEmpty() || after.isEmpty());
  EXPECT_NEAR(after.center().x() - before.center().x(), -3, 0.01) << "at the camera's 1 m/s, the other way";
}

}  // namespace
}  // namespace covis::synth
