// SPDX-License-Identifier: Apache-2.0
// The error that rectification left in a pair's columns, found beside other work on a stereo map.
#include "covis/loops/columns_refinement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/features/straightening.h"
#include "covis/optimization/columns_estimation.h"
#include "covis/optimization/test_pair_problem.h"

namespace covis {
namespace {

using pair_test::kPair;
using pair_test::pair_problem;

constexpr ShiftField kOff{{0.1, 0.5, 0, 0, 1, -2, 0}};

// The map of a problem: its views are key frames.
void add_map(const BundleProblem& problem, SharedMap& shared) {
  const auto map = shared.write();
  map->set_camera(kPair);
  const auto pyramid = std::make_shared<ScalePyramid>(8, 1.2f);
  std::vector<MapPointId> points(problem.points.size());
  for (size_t pose = 0; pose < problem.poses.size(); ++pose) {
    auto f = std::make_shared<Features>();
    f->pyramid = pyramid;
    std::vector<size_t> seen;
    for (const BundleObservation& o : problem.observations) {
      if (o.pose != static_cast<int>(pose)) continue;
      f->x.push_back(o.u);
      f->y.push_back(o.v);
      f->angle.push_back(0);
      f->u_right.push_back(o.u - o.disparity.pixels);
      f->depth.push_back(static_cast<float>(kPair.bf) / o.disparity.pixels);
      f->level.push_back(0);
      f->descriptor.push_back({});
      seen.push_back(static_cast<size_t>(o.point));
    }
    f->grid.build({0, 0, 640, 480}, f->x, f->y);
    const auto serial = static_cast<int64_t>(map->next_serial());
    const KeyFrameId id = map->add_key_frame(serial, serial, problem.poses[pose], f);
    for (uint32_t i = 0; i < seen.size(); ++i) {
      MapPointId& point = points[seen[i]];
      if (point.valid()) {
        map->add_observation(point, id, i);
      } else {
        point = map->add_point(problem.points[seen[i]], id, i);
      }
    }
    map->attach_to_tree(id);
  }
}

// True: an error was found.
bool refine(SharedMap& shared) {
  const std::atomic<bool> interrupt{false};
  const auto job = ColumnsRefinement::of(*shared.read(), shared.read()->key_frames().front());
  return job && job->run(interrupt) && job->apply(shared);
}

TEST(ColumnsRefinement, TakesThemOutOfTheMap) {
  SharedMap shared;
  add_map(pair_problem(kOff, 1), shared);
  ASSERT_TRUE(refine(shared));
  const auto map = shared.read();
  const ShiftField& found = map->camera().right_columns;
  for (const double x : {-0.4, 0.0, 0.4})
    for (const double y : {-0.2, 0.0, 0.2}) EXPECT_NEAR(found.at(x, y), kOff.at(x, y), 0.1);
  map->for_each_key_frame([&](KeyFrameId, const KeyFrame& key_frame) {
    const Features& f = *key_frame.features;
    EXPECT_TRUE(straight_for(f, map->camera()));
    for (size_t i = 0; i < f.x.size(); ++i)
      EXPECT_NEAR(f.depth[i] * (f.x[i] - f.u_right[i]), kPair.bf, 1e-3 * kPair.bf);
  });
  // Points are where they are: the pair's depths were too small or too great by percents.
  const BundleProblem truth = pair_problem(kOff, 1);
  EXPECT_LT((map->at(map->key_frames().back()).T_cw.centre() - truth.poses.back().centre()).norm(), 0.02);
}

TEST(ColumnsRefinement, LeavesARectifiedPairAlone) {
  SharedMap shared;
  add_map(pair_problem({}, 1), shared);
  EXPECT_FALSE(refine(shared));
  EXPECT_FALSE(shared.read()->camera().right_columns.any());
}

// More observations say something else than fewer did.
TEST(ColumnsRefinement, CorrectsWhatItFoundBefore) {
  BundleAdjuster adjuster;
  BundleProblem problem = pair_problem(kOff, 2);
  ShiftField wrong = kOff;
  wrong.pixels[0] += 0.06;
  ASSERT_TRUE(take_out(wrong, problem));
  adjuster.solve(problem, {.iterations = 20});
  ASSERT_TRUE(refine_columns(problem, adjuster, 5));
  EXPECT_NEAR(problem.camera.right_columns.at(0, 0), kOff.at(0, 0), 0.05);
}

TEST(ColumnsRefinement, SeveralSubmapsAreLeftAlone) {
  SharedMap shared;
  add_map(pair_problem(kOff, 1), shared);
  const std::atomic<bool> interrupt{false};
  const auto job = ColumnsRefinement::of(*shared.read(), shared.read()->key_frames().front());
  ASSERT_TRUE(job && job->run(interrupt));
  {
    const auto map = shared.write();
    map->begin_submap(99, 99, SE3(), map->at(map->root()).features);
  }
  ASSERT_EQ(shared.read()->submaps().size(), 2u);
  EXPECT_FALSE(job->apply(shared));
}

}  // namespace
}  // namespace covis
