// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/moving_features.h"

#include <gmock/gmock.h>

#include <vector>

#include "covis/core/random.h"
#include "covis/core/test_allocation_counts.h"
#include "covis/features/test_features.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {
namespace {

constexpr Timestamp kStep = from_seconds(1.0 / 30);  // between frames

// A frame whose camera is that of the world: a wall three metres ahead with 12 by 9 features 50 pixels apart, and
// before it a thing 1.5 metres ahead with 4 by 4 features, 20 pixels apart.
class MovingFeaturesTest : public testing::Test {
 protected:
  MovingFeaturesTest() {
    camera.fx = camera.fy = 500;
    camera.cx = 320;
    camera.cy = 240;
    camera.bf = 40;
    for (int row = 0; row < 9; ++row) {
      for (int column = 0; column < 12; ++column) add(wall, 45.0 + 50 * column, 40.0 + 50 * row, 3);
    }
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) add(thing, 290.0 + 20 * column, 210.0 + 20 * row, 1.5);
    }
  }

  void add(std::vector<size_t>& group, double x, double y, double depth) {
    group.push_back(static_cast<size_t>(features.size()));
    covis::add(features, {.x = x, .y = y, .depth = depth});
  }
  TrackedFrame start(Timestamp stamp = kStep) {
    finish(features);
    TrackedFrame frame;
    frame.start(std::make_shared<const Features>(features), 0, stamp);
    return frame;
  }
  // Matches a feature with a point that is so many pixels to the left of where the feature is, and above.
  void match(TrackedFrame& frame, size_t i, double left = 0, double above = 0) const {
    const double z = features.depth[i];
    const Eigen::Vector3d ray = camera.unproject(features.x[i] - left, features.y[i] - above);
    frame.set_match(i, {static_cast<uint32_t>(i), 1}, z * ray, PointSource::map);
  }
  void match_wall(TrackedFrame& frame) const {
    for (const size_t i : wall) match(frame, i);
  }
  void refuse(TrackedFrame& frame, size_t i, double left, double above = 0) const {
    match(frame, i, left, above);
    frame.refuse_match(i);
  }
  static std::vector<size_t> moving(const TrackedFrame& frame) {
    std::vector<size_t> found;
    for (size_t i = 0; i < frame.source.size(); ++i) {
      if (frame.moves(i)) found.push_back(i);
    }
    return found;
  }
  std::vector<size_t> found_in(TrackedFrame& frame) {
    finder.find(frame, local_map, camera);
    return moving(frame);
  }

  Pinhole camera;
  Features features = no_features();
  std::vector<size_t> wall, thing;
  const LocalMap local_map;  // none of its points is new
  MovingFeatures finder;
};

TEST_F(MovingFeaturesTest, WhatIsDisplacedAlikeMoves) {
  TrackedFrame frame = start();
  match_wall(frame);
  for (const size_t i : thing) refuse(frame, i, 6);
  EXPECT_EQ(found_in(frame), thing);
}

TEST_F(MovingFeaturesTest, NothingMovesWhereAllAgree) {
  TrackedFrame frame = start();
  match_wall(frame);
  for (const size_t i : thing) match(frame, i);
  EXPECT_THAT(found_in(frame), testing::IsEmpty());
}

TEST_F(MovingFeaturesTest, MatchesRefusedAtRandomDoNotMove) {
  Random random(3);
  TrackedFrame frame = start();
  match_wall(frame);
  for (const size_t i : thing) refuse(frame, i, 24 * random.uniform() - 12, 24 * random.uniform() - 12);
  EXPECT_THAT(found_in(frame), testing::IsEmpty());
}

TEST_F(MovingFeaturesTest, AFewAmongManyThatAgreeDoNotMove) {
  TrackedFrame frame = start();
  match_wall(frame);
  for (size_t k = 0; k < 5; ++k) refuse(frame, thing[k], 6);
  for (size_t k = 5; k < thing.size(); ++k) match(frame, thing[k]);
  EXPECT_THAT(found_in(frame), testing::IsEmpty());
}

TEST_F(MovingFeaturesTest, FewerThanFourAreTooFew) {
  TrackedFrame frame = start();
  match_wall(frame);
  for (size_t k = 0; k < 3; ++k) refuse(frame, thing[5 * k], 6);
  EXPECT_THAT(found_in(frame), testing::IsEmpty());
}

// The features of one edge, and a second edge beside it: matches slide along them.
TEST_F(MovingFeaturesTest, WhatSlidAlongAnEdgeDoesNotMove) {
  std::vector<size_t> edge;
  for (int k = 0; k < 10; ++k) {
    add(edge, 420 + 8.0 * k, 300 + 4.0 * k, 1.5);
    add(edge, 420 + 8.0 * k, 350 + 4.0 * k, 1.5);
  }
  TrackedFrame along = start();
  match_wall(along);
  for (const size_t i : edge) refuse(along, i, 8, 4);
  EXPECT_THAT(found_in(along), testing::IsEmpty());
  TrackedFrame across = start();
  match_wall(across);
  for (const size_t i : edge) refuse(across, i, -4, 8);
  EXPECT_EQ(found_in(across), edge) << "across it no match slides";
}

TEST_F(MovingFeaturesTest, UnmatchedFeaturesOfTheThingMoveWithIt) {
  TrackedFrame frame = start();
  match_wall(frame);
  for (size_t k = 0; k < thing.size(); ++k) {
    if (k % 2 == 0) refuse(frame, thing[k], 6);
  }
  EXPECT_EQ(found_in(frame), thing) << "and nothing of the wall behind";
}

TEST_F(MovingFeaturesTest, AMatchRefusedForItsDepthAloneSaysNothing) {
  TrackedFrame frame = start();
  match_wall(frame);
  for (const size_t i : thing) {
    match(frame, i);
    frame.positions[i] *= 1.2;
    frame.refuse_match(i);
  }
  EXPECT_THAT(found_in(frame), testing::IsEmpty());
}

TEST_F(MovingFeaturesTest, ItIsRememberedForHalfASecond) {
  TrackedFrame frame = start();
  match_wall(frame);
  for (const size_t i : thing) refuse(frame, i, 6);
  finder.find(frame, local_map, camera);
  for (int k = 2; k < 40; ++k) {
    TrackedFrame next = start(k * kStep);
    for (size_t i = 0; i < next.source.size(); ++i) {
      match(frame, i);  // it stands now
      next.take_match(i, frame, i);
    }
    EXPECT_EQ(moving(next).size(), k <= 16 ? thing.size() : 0) << k << ": inherited";
    finder.find(next, local_map, camera);
    EXPECT_EQ(moving(next).size(), k <= 16 ? thing.size() : 0) << k << ": nothing renews it";
    frame = next;
  }
}

TEST_F(MovingFeaturesTest, WithoutEnoughPointsThatStandNothingIsFound) {
  const auto found_among = [&](size_t standing) {
    TrackedFrame frame = start();
    for (size_t k = 0; k < standing; ++k) match(frame, wall[k]);
    for (const size_t i : thing) refuse(frame, i, 6);
    return found_in(frame);
  };
  EXPECT_THAT(found_among(29), testing::IsEmpty());
  EXPECT_EQ(found_among(30), thing);
}

TEST_F(MovingFeaturesTest, ByOneCameraNothingIsFound) {
  camera.bf = 0;
  TrackedFrame frame = start();
  match_wall(frame);
  for (const size_t i : thing) refuse(frame, i, 6);
  EXPECT_THAT(found_in(frame), testing::IsEmpty());
}

TEST_F(MovingFeaturesTest, AllocatesNothing) {
  TrackedFrame frame = start();
  match_wall(frame);
  for (const size_t i : thing) refuse(frame, i, 6);
  finder.find(frame, local_map, camera);
  const long before = own_allocations;
  finder.find(frame, local_map, camera);
  EXPECT_EQ(own_allocations, before);
}

}  // namespace
}  // namespace covis
