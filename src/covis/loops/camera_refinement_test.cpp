// SPDX-License-Identifier: Apache-2.0
// The focal length adjusted beside other work on a monocular map.
#include "covis/loops/camera_refinement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/core/random.h"

namespace covis {
namespace {

// Views of a camera of focal length 500 that drives forward and turns, said to have `claimed` times that.
class Drive {
 public:
  Drive(SharedMap& shared, double claimed, size_t views) : shared_(shared) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (size_t k = 0; k < views; ++k) {
      const SE3 rotation = SE3::exp((Vector6d() << 0, 0, 0, 0, 0.05 * static_cast<double>(k), 0).finished());
      T_wc.emplace_back(rotation.R(), centre);
      centre += rotation.R() * Eigen::Vector3d(0, 0, 0.5);
    }
    for (size_t p = 0; p < 800; ++p)
      places_.push_back(T_wc[p % views] *
                        Eigen::Vector3d(random_.uniform(-4, 4), random_.uniform(-3, 3), random_.uniform(4, 14)));
    points_.resize(places_.size());
    shared.write()->set_camera({500 * claimed, 500 * claimed, 320, 240, 0});
  }

  void map_views(size_t first, size_t last) {
    const Pinhole truth{500, 500, 320, 240, 0};
    const auto map = shared_.write();
    for (size_t k = first; k < last; ++k) {
      const SE3 T_cw = T_wc[k].inverse();
      auto f = std::make_shared<Features>();
      f->pyramid = pyramid_;
      std::vector<size_t> seen;
      for (size_t p = 0; p < places_.size(); ++p) {
        const Eigen::Vector3d p_c = T_cw * places_[p];
        if (p_c.z() < 1) continue;
        const Eigen::Vector2d pixel = truth.project(p_c);
        if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() >= 640 || pixel.y() >= 480) continue;
        f->x.push_back(static_cast<float>(pixel.x() + random_.uniform(-0.5, 0.5)));
        f->y.push_back(static_cast<float>(pixel.y() + random_.uniform(-0.5, 0.5)));
        f->angle.push_back(0);
        f->u_right.push_back(-1);
        f->depth.push_back(0);
        f->level.push_back(0);
        f->descriptor.push_back({});
        seen.push_back(p);
      }
      f->grid.build({0, 0, 640, 480}, f->x, f->y);
      const auto serial = static_cast<int64_t>(map->next_serial());
      const KeyFrameId id = map->add_key_frame(serial, serial, T_cw, f);
      for (uint32_t i = 0; i < seen.size(); ++i) {
        MapPointId& point = points_[seen[i]];
        if (point.valid()) {
          map->add_observation(point, id, i);
        } else {
          point = map->add_point(places_[seen[i]], id, i);
        }
      }
      map->attach_to_tree(id);
    }
  }

  std::vector<SE3> T_wc;

 private:
  SharedMap& shared_;
  Random random_{3};
  std::vector<Eigen::Vector3d> places_;
  std::vector<MapPointId> points_;
  std::shared_ptr<const ScalePyramid> pyramid_ = std::make_shared<ScalePyramid>(8, 1.2f);
};

void drive(SharedMap& shared, double claimed) { Drive(shared, claimed, 16).map_views(0, 16); }

constexpr double kTruth = 500;  // pixels

BackgroundAdjustment::Outcome refine(SharedMap& map, double given_fx) {
  BackgroundAdjustment background;
  background.start(CameraRefinement::of(*map.read(), map.read()->root(), {.given_fx = given_fx}), 1);
  EXPECT_TRUE(background.running());
  const BackgroundAdjustment::Outcome outcome = background.apply(map);
  EXPECT_FALSE(background.running());
  EXPECT_EQ(outcome.kind, AdjustmentKind::camera);
  EXPECT_EQ(map.read()->check(), "");
  return outcome;
}

// Mean distance of the points' projections to where they were seen, pixels.
double reprojection_error(const Map& map) {
  double sum = 0, count = 0;
  map.for_each_point([&](MapPointId, const MapPoint& point) {
    for (const Observation& o : point.observations) {
      const KeyFrame& key_frame = map.at(o.key_frame);
      const Eigen::Vector2d at = map.camera().project(key_frame.T_cw * point.position_w);
      sum += std::hypot(at.x() - key_frame.features->x[o.feature], at.y() - key_frame.features->y[o.feature]);
      ++count;
    }
  });
  return sum / count;
}

// Half of the error left is not enough, and neither is the camera without the map.
TEST(CameraRefinement, GivesTheMapTheCameraItTells) {
  for (const double claimed : {0.985, 1.02}) {
    SharedMap map;
    drive(map, claimed);
    const double before = std::abs(map.read()->camera().fx - kTruth);
    ASSERT_GT(before, 7);
    const uint64_t moves = map.read()->moves();
    EXPECT_TRUE(refine(map, claimed * kTruth).applied);
    const auto m = map.read();
    EXPECT_LT(std::abs(m->camera().fx - kTruth), 1.5) << "the error was " << before << " pixels";
    EXPECT_EQ(m->camera().fy, m->camera().fx);
    EXPECT_EQ(m->camera().cx, 320);
    EXPECT_GT(m->moves(), moves);
    EXPECT_LT(reprojection_error(*m), 0.45) << "keypoints are half a pixel off at most, 0.38 in the mean";
  }
}

// Frames between key frames are to follow, also beside those that were mapped while the answer was worked out.
TEST(CameraRefinement, SaysHowKeyFramesMoved) {
  constexpr size_t kCopied = 16, kViews = 19;
  SharedMap map;
  Drive views(map, 1.02, kViews);
  views.map_views(0, kCopied);
  BackgroundAdjustment background;
  background.start(CameraRefinement::of(*map.read(), map.read()->root(), {.given_fx = 1.02 * kTruth}), 1);
  views.map_views(kCopied, kViews);
  std::vector<SE3> before;
  for (const KeyFrameId& id : map.read()->key_frames()) before.push_back(map.read()->at(id).T_cw);
  const BackgroundAdjustment::Outcome outcome = background.apply(map);
  ASSERT_TRUE(outcome.applied);
  const auto m = map.read();
  EXPECT_EQ(m->check(), "");
  ASSERT_EQ(outcome.moves.of.size(), kViews);
  EXPECT_EQ(outcome.moves.moves, m->moves());
  for (const KeyFrameMove& move : outcome.moves.of) {
    const KeyFrame& key_frame = m->at(move.key_frame);
    EXPECT_EQ(move.frame, key_frame.frame);
    EXPECT_EQ(move.before.t(), before[key_frame.serial].t());
    EXPECT_EQ(move.after.t(), key_frame.T_cw.t());
    EXPECT_EQ(move.scale, key_frame.scale);
  }
}

TEST(CameraRefinement, LeavesARightOneAndTheMap) {
  SharedMap map;
  drive(map, 1.0);
  const uint64_t moves = map.read()->moves();
  std::vector<SE3> before;
  for (const KeyFrameId& id : map.read()->key_frames()) before.push_back(map.read()->at(id).T_cw);
  EXPECT_FALSE(refine(map, kTruth).applied);
  const auto m = map.read();
  EXPECT_EQ(m->camera().fx, kTruth);
  EXPECT_EQ(m->moves(), moves);
  size_t k = 0;
  for (const KeyFrameId& id : m->key_frames()) EXPECT_EQ(m->at(id).T_cw.t(), before[k++].t());
}

// In steps, as an estimate is good only near.
TEST(CameraRefinement, AGreatErrorIsMendedToo) {
  for (const double claimed : {0.96, 1.035, 1.045}) {
    SharedMap map;
    drive(map, claimed);
    EXPECT_TRUE(refine(map, claimed * kTruth).applied);
    EXPECT_NEAR(map.read()->camera().fx, kTruth, 2.5) << claimed;
  }
}

// The map tells one more than 5 % from the one given, however near the present one is.
TEST(CameraRefinement, KeepsNearTheGivenOne) {
  SharedMap map;
  drive(map, 1.02);
  EXPECT_FALSE(refine(map, 1.06 * kTruth).applied);
  EXPECT_EQ(map.read()->camera().fx, 1.02 * kTruth);
}

TEST(CameraRefinement, IsLeftWhereAnotherSubmapWasBegunOrTheSubmapIsGone) {
  for (const bool gone : {false, true}) {
    SharedMap map;
    drive(map, 1.02);
    BackgroundAdjustment background;
    const RefinableCamera claimed{.given_fx = 1.02 * kTruth};
    background.start(CameraRefinement::of(*map.read(), map.read()->root(), claimed), 1);
    uint64_t moves = 0;
    {
      const auto m = map.write();
      if (gone) {
        m->erase_submap(m->submaps().front().id);
      } else {
        m->begin_submap(99, 99, SE3(), m->at(m->root()).features);
      }
      moves = m->moves();
    }
    EXPECT_FALSE(background.apply(map).applied);
    EXPECT_EQ(map.read()->camera().fx, 1.02 * kTruth);
    EXPECT_EQ(map.read()->moves(), moves);
  }
}

TEST(CameraRefinement, IsAskedForAsTheMapGrowsWhileItIsOneAndNotLarge) {
  Map map;
  RefinementSchedule schedule;
  const auto features = [] {
    auto f = std::make_shared<Features>();
    f->pyramid = std::make_shared<ScalePyramid>(8, 1.2f);
    return f;
  }();
  std::vector<uint32_t> asked;
  while (map.next_serial() < 160) {
    const auto serial = static_cast<int64_t>(map.next_serial());
    map.attach_to_tree(map.add_key_frame(serial, serial, SE3(), features));
    if (const auto age = schedule.ask(map)) {
      asked.push_back(map.next_serial());
      EXPECT_EQ(*age, 2 + static_cast<int>(map.next_serial()) / 25);
    }
  }
  EXPECT_EQ(asked, (std::vector<uint32_t>{20, 25, 31, 38, 47, 58, 72, 90}));
  Map empty;
  schedule.restart(empty);
  EXPECT_FALSE(schedule.ask(empty));
  Map two;
  for (int64_t k = 0; k < 30; ++k) two.begin_submap(k, k, SE3(), features);
  EXPECT_FALSE(RefinementSchedule().ask(two));
}

}  // namespace
}  // namespace covis
