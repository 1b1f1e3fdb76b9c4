// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/views_between.h"

#include <gtest/gtest.h>

#include <functional>
#include <utility>
#include <vector>

#include "covis/core/random.h"

namespace covis {
namespace {

using Eigen::Vector3d;

constexpr Pinhole kCamera{500, 500, 320, 240, 0};

// A camera goes past a wall at a slant; part: from 0, the first view, to 1, the second.
using Path = std::function<SE3(double part)>;

SE3 round_a_bend(double part) {
  return SE3(so3_exp(Vector3d(0.05, -0.4, 0.02) * part), Vector3d(-1.2 * part, 0.9 * part * part, 0.5 * part * part));
}

SE3 straight_on(double part) { return SE3(so3_exp(Vector3d::Zero()), Vector3d(-1.2, 0.1, -0.4) * part); }

class WallTest : public testing::Test {
 protected:
  // The places of the wall's points in a view.
  std::vector<Eigen::Vector2d> view(const SE3& T_c1, double noise = 0.4) {
    std::vector<Eigen::Vector2d> places;
    for (const Vector3d& p : wall_) {
      places.push_back(kCamera.project(T_c1 * p));
      places.back() += noise * Eigen::Vector2d(random_.normal(), random_.normal());
    }
    return places;
  }

  // The motion chosen at the end of the path by so many views in between, of so much noise; null: none. `motions` are
  // those to choose from.
  const TwoViewMotion* choose(const Path& path, int between, double noise = 0.4) {
    views.restart(0);
    for (int k = 1; k <= between; ++k) {
      const double part = k / (between + 1.0);
      std::vector<ViewsBetween::Sighting> seen;
      uint32_t feature = 0;
      for (const Eigen::Vector2d& place : view(path(part), noise))
        seen.push_back({2 * feature++, static_cast<float>(place.x()), static_cast<float>(place.y()), 1});
      if (views.is_next_due()) views.add(from_seconds(part), std::move(seen));
    }
    const TwoViewResult result = reconstruct_two_views({first_, view(path(1)), {}}, kCamera, {});
    EXPECT_EQ(result.status, TwoViewStatus::no_clear_winner) << "two views of a plane";
    motions = result.motions;
    EXPECT_GE(motions.size(), 2u);
    return views.choose(motions, features(), kCamera, from_seconds(1));
  }

  // Every second feature is matched.
  std::vector<uint32_t> features() const {
    std::vector<uint32_t> features(wall_.size());
    for (uint32_t k = 0; k < features.size(); ++k) features[k] = 2 * k;
    return features;
  }

  ViewsBetween views;
  std::vector<TwoViewMotion> motions;

 private:
  static std::vector<Vector3d> wall() {
    Random random(7);
    std::vector<Vector3d> points;
    for (int i = 0; i < 200; ++i) {
      const double x = random.uniform(-1.2, 1.6), y = random.uniform(-1, 1);
      points.emplace_back(x, y, 4 + 0.5 * x - 0.2 * y);
    }
    return points;
  }

  Random random_{3};
  const std::vector<Vector3d> wall_ = wall();
  const std::vector<Eigen::Vector2d> first_ = view(SE3());
};

TEST_F(WallTest, ABendDecides) {
  for (const int between : {3, 7, 8, 20}) {
    const TwoViewMotion* chosen = choose(round_a_bend, between);
    ASSERT_NE(chosen, nullptr) << between;
    const SE3 truth = round_a_bend(1);
    EXPECT_LT(so3_log(chosen->T_21.R() * truth.R().transpose()).norm(), 0.02) << between;
    EXPECT_GT(chosen->T_21.t().dot(truth.t().normalized()), 0.995) << between;
  }
}

TEST_F(WallTest, NoMotionIsChosenWithoutViewsBetween) { EXPECT_EQ(choose(round_a_bend, 0), nullptr); }

TEST_F(WallTest, NoMotionIsChosenOnAStraightWay) { EXPECT_EQ(choose(straight_on, 7), nullptr); }

TEST_F(WallTest, ViewsOfAnotherFirstOneAreForgotten) {
  ASSERT_NE(choose(round_a_bend, 7), nullptr);
  views.restart(0);
  EXPECT_EQ(views.choose(motions, features(), kCamera, from_seconds(1)), nullptr);
}

// The right motion is clearly the better one, but not good.
TEST_F(WallTest, ViewsThatNoMotionExplainsTellNothing) {
  EXPECT_NE(choose(round_a_bend, 7, 0.6), nullptr);
  EXPECT_EQ(choose(round_a_bend, 7, 0.75), nullptr);
}

}  // namespace
}  // namespace covis
