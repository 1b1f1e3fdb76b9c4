// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/torn_image.h"

#include <gtest/gtest.h>

#include "covis/geometry/measurement.h"
#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

constexpr float kTear = 240;  // the row from which on rows are displaced: the lower half of the image
constexpr Timestamp kStep = 66'000'000;

// A wall of points that a camera knows. Frames see it from a known pose, and match what is where it is expected.
class TornImageTest : public testing::Test {
 protected:
  TornImageTest() {
    world.add_key_frames(3, 0, 2);
    local_map.update(*world.shared.read(), {}, world.shared.read()->key_frames().front(), 10);
    expected.assign(local_map.points.size(), 1);
  }
  // The features for which `moves` holds are elsewhere, and show no known point there. way: to the right; or by a
  // feature's number.
  template <class Moves>
  TrackedFrame displaced(float way, Moves moves, Timestamp stamp = 0) const {
    return displaced_by([way](size_t) { return Eigen::Vector2f(way, 0); }, moves, stamp);
  }
  template <class Way, class Moves>
  TrackedFrame displaced_by(Way way, Moves moves, Timestamp stamp = 0) const {
    const PointScene::View whole = scene.view(pose);
    const PointScene::View view = edited(whole, [&](Features& f) {
      for (size_t i = 0; i < f.x.size(); ++i) {
        if (!moves(i, f.y[i])) continue;
        const Eigen::Vector2f by = way(i);
        f.x[i] += by.x();
        f.y[i] += by.y();
      }
    });
    TrackedFrame frame = frame_of(view, pose, 0, stamp);
    match_points(frame, view, world);
    for (size_t i = 0; i < view.point.size(); ++i) {
      if (moves(i, whole.features->y[i])) frame.drop_match(i);
    }
    return frame;
  }
  TrackedFrame torn(float way, Timestamp stamp = 0) const {
    return displaced(
        way, [](size_t, float y) { return y > kTear; }, stamp);
  }
  DisplacedRows look(const TrackedFrame& frame) { return image.look(local_map, expected, frame, scene.camera); }
  bool judge(const TrackedFrame& frame) { return image.judge(local_map, expected, frame, scene.camera); }

  const PointScene scene = PointScene::wall(2400);
  SceneMap world{scene};
  const SE3 pose = scene.T_cw(1);
  LocalMap local_map;
  std::vector<uint8_t> expected;
  TornImage image;
};

TEST_F(TornImageTest, DisplacedRowsAreSeenWithTheirPoints) {
  const TrackedFrame frame = torn(150);
  const DisplacedRows found = look(frame);
  EXPECT_TRUE(found.shows_tear());
  EXPECT_EQ(found.inliers, 0);
  const int missing = static_cast<int>(frame.source.size()) - frame.matches();
  EXPECT_GT(found.displaced, 0.7 * missing);
  EXPECT_LT(found.displaced, 1.3 * missing);
  EXPECT_TRUE(look(torn(-150)).shows_tear());
}

TEST_F(TornImageTest, AWholeFrameIsNotTorn) {
  EXPECT_FALSE(look(torn(0)).shows_tear()) << "points are where they are expected, however few are matched";
  EXPECT_FALSE(judge(displaced(0, [](size_t, float) { return false; })));
}

TEST_F(TornImageTest, AFewPixelsAreNoTear) { EXPECT_FALSE(look(torn(30)).may_show_tear()); }

// Things that are alike and stand in a row, of which each is taken for the next one.
TEST_F(TornImageTest, DisplacedPointsAmongRightOnesAreNoTear) {
  const DisplacedRows found = look(displaced(150, [](size_t i, float) { return i % 3 == 0; }));
  EXPECT_GT(found.displaced, 50);
  EXPECT_GT(found.inliers, found.displaced);
  EXPECT_FALSE(found.may_show_tear());
}

// Tiles: in a part of the image most are not found, and each of the others is taken for one of its neighbours.
TEST_F(TornImageTest, WaysThatDifferOrLeadAcrossTheRowsAreNoTear) {
  const auto lower = [](size_t, float y) { return y > kTear; };
  const auto neighbours = [](size_t i) { return Eigen::Vector2f(i % 2 == 0 ? 100 : -100, i % 4 < 2 ? 0 : 60); };
  const DisplacedRows differ = look(displaced_by(neighbours, lower));
  EXPECT_GE(differ.sampled, 20);
  EXPECT_LE(differ.inliers, 0.15 * differ.displaced);
  EXPECT_FALSE(differ.shows_tear());
  const DisplacedRows across = look(displaced_by([](size_t) { return Eigen::Vector2f(30, 60); }, lower));
  EXPECT_FALSE(across.may_show_tear());
}

TEST_F(TornImageTest, RowsThatShowOtherThingsAreNoTear) {
  const auto lower = [](size_t, float y) { return y > kTear; };
  TrackedFrame frame = displaced(0, lower);
  const PointScene other = PointScene::wall(2400, 20, 2);  // something stands before the camera
  frame.features = edited({frame.features, {}}, [&](Features& f) {
                     for (size_t i = 0; i < f.y.size(); ++i) {
                       if (lower(i, f.y[i])) f.descriptor[i] = other.points[i].descriptor;
                     }
                   }).features;
  EXPECT_EQ(look(frame).displaced, 0);
}

TEST_F(TornImageTest, AfterATornFrameFewPointsAreEnough) {
  const auto all = expected;
  std::vector<uint8_t> few(all.size(), 0);
  int left = 6;
  for (size_t k = 0; k < few.size() && left > 0; ++k) {
    const PredictedMeasurement h = predict_measurement(pose * local_map.points.position(k), scene.camera);
    few[k] = h.v > kTear && h.v < 480 && h.u > 0 && h.u < 640;
    left -= few[k];
  }
  ASSERT_EQ(left, 0);
  expected = few;
  EXPECT_FALSE(judge(torn(150, 0))) << "by themselves they say too little";
  expected = all;
  EXPECT_TRUE(judge(torn(150, kStep)));
  expected = few;
  for (int i = 2; i < 10; ++i) EXPECT_TRUE(judge(torn(150, i * kStep))) << i;
}

TEST_F(TornImageTest, ItIsBelievedForThreeSeconds) {
  int torn_frames = 0;
  for (int i = 0; i < 100; ++i) torn_frames += judge(torn(150, i * kStep));
  EXPECT_NEAR(static_cast<double>(torn_frames * kStep), 3e9, 2.0 * kStep)
      << "a thing that was moved may fill these rows";
  image.whole();
  EXPECT_TRUE(judge(torn(150, 100 * kStep)));
}

TEST_F(TornImageTest, ItGoesOnForAMomentAndEndsWithAWholeFrame) {
  EXPECT_TRUE(judge(torn(150, 0)));
  EXPECT_TRUE(judge(torn(0, kStep))) << "the next one may show too little to tell";
  EXPECT_TRUE(image.was_torn(kStep));
  EXPECT_FALSE(judge(torn(0, 4 * kStep)));
  EXPECT_FALSE(image.was_torn(4 * kStep));
  EXPECT_TRUE(image.may_go_on(4 * kStep)) << "a map that begins now may begin with a torn frame";
  EXPECT_FALSE(image.may_go_on(20 * kStep));
  EXPECT_TRUE(judge(torn(150, 20 * kStep)));
  image.whole();
  EXPECT_FALSE(image.may_go_on(20 * kStep));
  EXPECT_FALSE(judge(torn(0, 21 * kStep)));
}

TEST_F(TornImageTest, FramesThatShowFarTooLittleAreTornAsThoseBefore) {
  EXPECT_FALSE(image.judge_after_torn(0)) << "none was torn";
  EXPECT_TRUE(judge(torn(150, 0)));
  int frames = 0;
  for (int i = 1; i < 100; ++i) frames += image.judge_after_torn(i * kStep);
  EXPECT_NEAR(static_cast<double>(frames * kStep), 3e9, 2.0 * kStep);
  image.whole();
  EXPECT_FALSE(image.judge_after_torn(100 * kStep));
}

}  // namespace
}  // namespace covis
