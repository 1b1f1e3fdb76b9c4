// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/relocaliser.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/map/camera_change.h"
#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

// A camera that looked all around in 24 key frames.
class RelocaliserTest : public testing::Test {
 protected:
  RelocaliserTest() : vocabulary(number_points(scene)), world(scene) {
    world.add_key_frames(24, 0, 2);
    // Some points are known for long: a place has to show them.
    const auto map = world.shared.write();
    for (const MapPointId id : map->points()) {
      map->count_visible(id, 9);
      map->count_found(id, 9);
    }
  }

  // Poses between key frames, nearest to key frame `k`.
  static SE3 near_key_frame(size_t k) {
    const double angle = 2 * std::numbers::pi * (static_cast<double>(k) + 0.3) / 24;
    return SE3(so3_exp({0.02, angle, 0}), {2 * std::sin(angle), 0.1, 2 * std::cos(angle)}).inverse();
  }
  Relocaliser relocaliser(std::shared_ptr<const Vocabulary> words, int seed = 0) const {
    return Relocaliser(world.shared, options, seed, std::move(words));
  }
  // Looks for a frame; its pose must be right when it has one.
  bool finds(Relocaliser& by, const SE3& T_cw, KeyFrameId near = {}, int64_t index = 0,
             std::optional<uint32_t> but = {}) {
    TrackedFrame frame = frame_of(scene.view(T_cw), SE3(), index);
    search.refresh_camera(*world.shared.read());
    TrackFigures figures;
    if (!by.find(frame, search, &world.shared, {near, but}, figures)) return false;
    EXPECT_LT(distance(frame.T_cw, T_cw), 1e-3);
    EXPECT_EQ(figures.inliers, frame.matches());
    EXPECT_GE(figures.inliers, options.recovery.min_inliers_recovered);
    EXPECT_EQ(figures.local_points, search.local_map.size());
    EXPECT_LE(figures.local_in_view, figures.local_points);
    return true;
  }

  PointScene scene = PointScene::ring();
  std::shared_ptr<const Vocabulary> vocabulary;
  SceneMap world;
  TrackerOptions options;
  PoseSearch search{options.recovery, Subject::stream};
};

TEST_F(RelocaliserTest, TheVocabularyNumbersThePoints) {
  for (size_t p = 0; p < scene.points.size(); p += 37) EXPECT_EQ(vocabulary->word(scene.points[p].descriptor), p);
}

TEST_F(RelocaliserTest, FindsByWords) {
  for (const size_t k : {5, 13, 20}) {
    Relocaliser by_words = relocaliser(vocabulary);
    ASSERT_TRUE(finds(by_words, near_key_frame(k))) << k;
    EXPECT_EQ(search.local_map.reference.id, world.frames[k]) << "it sees most of what the camera sees";
  }
}

TEST_F(RelocaliserTest, WithoutWordsFindsAroundTheLastReference) {
  Relocaliser by_neighbours = relocaliser(nullptr);
  EXPECT_TRUE(finds(by_neighbours, near_key_frame(13), world.frames[13]));
  Relocaliser by_a_neighbour = relocaliser(nullptr);
  EXPECT_TRUE(finds(by_a_neighbour, near_key_frame(13), world.frames[15]));
}

TEST_F(RelocaliserTest, TheLastReferenceMayBeErased) {
  const KeyFrameId child = world.frames[14];
  ASSERT_TRUE(world.shared.write()->erase_key_frame(child));
  Relocaliser by_parent = relocaliser(nullptr);
  EXPECT_TRUE(finds(by_parent, near_key_frame(13), child));
}

TEST_F(RelocaliserTest, WithoutWordsAllKeyFramesHaveTheirTurn) {
  Relocaliser in_turn = relocaliser(nullptr);
  const SE3 place = near_key_frame(12);
  int tries = 0;
  while (tries < 10 && !finds(in_turn, place, {}, tries)) ++tries;
  EXPECT_EQ(tries, 2) << "five a frame: 0 to 4, 5 to 9, 10 to 14";
}

TEST_F(RelocaliserTest, NothingIsFoundWhereNothingIsAlike) {
  const PointScene other = PointScene::ring(2400, 48, 2);
  TrackedFrame frame = frame_of(other.view(near_key_frame(3)), SE3());
  search.refresh_camera(*world.shared.read());
  TrackFigures figures;
  Relocaliser by_words = relocaliser(vocabulary);
  for (int i = 0; i < 12; ++i)
    EXPECT_FALSE(by_words.find(frame, search, &world.shared, {world.frames[7], {}}, figures));
  EXPECT_EQ(search.local_map.reference.id, world.frames[7]) << "candidates leave no reference behind";
  EXPECT_FALSE(search.place.tentative());
}

TEST_F(RelocaliserTest, ASubmapMayBeLeftOut) {
  const uint32_t submap = world.shared.read()->at(world.frames[7]).submap;
  Relocaliser by_words = relocaliser(vocabulary), near_by = relocaliser(nullptr);
  EXPECT_FALSE(finds(by_words, near_key_frame(7), world.frames[7], 0, submap));
  EXPECT_FALSE(finds(near_by, near_key_frame(7), world.frames[7], 0, submap));
  EXPECT_TRUE(finds(by_words, near_key_frame(7), world.frames[7], 0, submap + 1));
}

TEST_F(RelocaliserTest, TooFewInliersAreNoPlace) {
  options.recovery.min_inliers_recovered = 2000;
  Relocaliser demanding = relocaliser(vocabulary);
  EXPECT_FALSE(finds(demanding, near_key_frame(5)));
}

TEST_F(RelocaliserTest, ShareOfThePointsInViewIsAskedFor) {
  options.recovery.min_recovered_share = 1.01;
  Relocaliser demanding = relocaliser(vocabulary);
  EXPECT_FALSE(finds(demanding, near_key_frame(5)));
}

TEST_F(RelocaliserTest, ThePlaceIsTentativeAtFirst) {
  Relocaliser by_words = relocaliser(vocabulary);
  ASSERT_TRUE(finds(by_words, near_key_frame(5)));
  EXPECT_TRUE(search.place.tentative());
}

TEST_F(RelocaliserTest, AThingThatLooksAlikeIsNotThePlace) {
  // The things within 17 degrees of the middle of the view stand elsewhere too, among others.
  PointScene elsewhere = PointScene::ring(2400, 48, 2);
  const SE3 T_cw = near_key_frame(5);
  for (const PointScene::Point& point : scene.points) {
    const Eigen::Vector3d p_c = T_cw * point.position_w;
    if (p_c.z() > 0 && std::hypot(p_c.x(), p_c.y()) < 0.3 * p_c.z()) elsewhere.points.push_back(point);
  }
  TrackedFrame frame = frame_of(elsewhere.view(T_cw), SE3());
  search.refresh_camera(*world.shared.read());
  TrackFigures figures;
  Relocaliser by_words = relocaliser(vocabulary);
  EXPECT_FALSE(by_words.find(frame, search, &world.shared, {}, figures));
  EXPECT_GE(figures.inliers, options.recovery.min_inliers_recovered) << "though enough of it matches";
}

TEST_F(RelocaliserTest, WhileTheMapIsHiddenItsCopiesServe) {
  const SE3 T_cw = near_key_frame(5);
  search.refresh_camera(*world.shared.read());
  search.local_map.update(*world.shared.read(), {}, world.frames[5], 80);
  const uint32_t submap = world.shared.read()->at(world.frames[5]).submap;
  world.shared.write()->erase_submap(submap);
  TrackedFrame frame = frame_of(scene.view(T_cw), SE3());
  TrackFigures figures;
  Relocaliser by_copies = relocaliser(vocabulary);
  ASSERT_TRUE(by_copies.find(frame, search, nullptr, {world.frames[5], {}}, figures));
  EXPECT_LT(distance(frame.T_cw, T_cw), 1e-3);
  EXPECT_TRUE(search.place.tentative()) << "nobody could be asked what is seen from there";
  TrackedFrame far = frame_of(scene.view(near_key_frame(15)), SE3());
  EXPECT_FALSE(by_copies.find(far, search, nullptr, {world.frames[5], {}}, figures));
  search.local_map.clear();
  EXPECT_FALSE(by_copies.find(frame, search, nullptr, {world.frames[5], {}}, figures)) << "there is no copy";
}

// ---- Single images ----

TEST_F(RelocaliserTest, LocatesAnImageFromNothingButTheImage) {
  const SE3 T_cw = near_key_frame(17);
  const auto located = relocaliser(vocabulary).locate(scene.view(T_cw).features, 0);
  ASSERT_TRUE(located);
  EXPECT_LT(distance(located->T_cw, T_cw), 1e-3);
  EXPECT_EQ(located->submap, 0u);
  const PointScene other = PointScene::ring(2400, 48, 2);
  EXPECT_FALSE(relocaliser(vocabulary).locate(other.view(T_cw).features, 0));
}

TEST_F(RelocaliserTest, AnImageOfAnotherCameraIsLocatedByThatCamera) {
  PointScene zoomed = scene;
  zoomed.camera = {650, 650, 300, 250, 0};
  const SE3 T_cw = near_key_frame(17);
  const FeaturesPtr features = zoomed.view(T_cw, Sensor::monocular).features;
  {
    const auto map = world.shared.write();
    MapState state = map->state();
    ASSERT_TRUE(express_in(state, {}, {{}, zoomed.camera}));
    Map expressed = Map::from_state(std::move(state)).value();
    const std::vector<KeyFrameId> before = map->key_frames(), after = expressed.key_frames();
    for (size_t k = 0; k < before.size(); ++k) expressed.set_words(after[k], map->at(before[k]).words);
    *map = std::move(expressed);
  }
  const auto located = relocaliser(vocabulary).locate(features, 0);
  ASSERT_TRUE(located);
  EXPECT_LT(distance(located->T_cw, T_cw), 1e-3);
}

TEST_F(RelocaliserTest, OneImageDoesNotChangeThePlaceOfTheNext) {
  scene.noise = 1;
  const FeaturesPtr image = scene.view(near_key_frame(17)).features, between = scene.view(near_key_frame(3)).features;
  Relocaliser by_words = relocaliser(vocabulary);
  const auto first = by_words.locate(image, 5);
  ASSERT_TRUE(by_words.locate(between, 6));
  const auto again = by_words.locate(image, 5);
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->T_cw.t(), again->T_cw.t());
  EXPECT_EQ(first->T_cw.R(), again->T_cw.R());
}

// ---- What is drawn ----

class RelocaliserDrawsTest : public RelocaliserTest {
 protected:
  // The pose that noisy features get: to the bit another one when RANSAC starts from other samples.
  Eigen::Vector3d position(int seed, int64_t frame) {
    scene.noise = 1.5;
    return relocaliser(vocabulary, seed).locate(scene.view(near_key_frame(17)).features, frame).value().T_cw.t();
  }
};

TEST_F(RelocaliserDrawsTest, AFrameDrawsTheSameSamplesEachTime) { EXPECT_EQ(position(3, 8), position(3, 8)); }

TEST_F(RelocaliserDrawsTest, FramesAndSeedsDrawSamplesOfTheirOwn) {
  EXPECT_NE(position(0, 0), position(0, 1));
  EXPECT_NE(position(0, 1), position(1, 1));
  EXPECT_NE(position(0, 1), position(1, 0)) << "the sum of both tells nothing";
}

}  // namespace
}  // namespace covis
