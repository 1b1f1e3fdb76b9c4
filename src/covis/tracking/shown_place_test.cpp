// SPDX-License-Identifier: Apache-2.0
// The image beside the matches as evidence of a place.
#include <gtest/gtest.h>

#include "covis/features/frontend.h"
#include "covis/features/test_images.h"
#include "covis/tracking/place_check.h"

namespace covis {
namespace {

// A map of one key frame before a wall, two metres away, all of whose points match usually. The camera is where that
// was; it came from there, or was somewhere else before.
class ShownPlaceTest : public testing::Test {
 protected:
  static constexpr int kWidth = 640, kHeight = 480;
  enum class Before { there, elsewhere };

  ShownPlaceTest() {
    features = frontend.monocular(image.view());
    const auto map = shared.write();
    map->set_camera(camera.pinhole);
    const KeyFrameId key_frame = map->add_key_frame(0, 0, SE3(), features->for_key_frame());
    for (uint32_t i = 0; i < static_cast<uint32_t>(features->size()); ++i) {
      const MapPointId id = map->add_point(2 * camera.pinhole.unproject(features->x[i], features->y[i]), key_frame, i);
      map->count_visible(id, 9);
      map->count_found(id, 9);
      points.push_back(id);
    }
    local_map.update(*map, {}, key_frame, 80);
  }
  // Judges a frame with so many tenths of the points matched. Its image shows this; null: the image is gone.
  bool is_right(size_t tenths, const ImageU8* shown, Before before, Arrival arrival) {
    return judge(tenths, shown, before,
                 [&](PlaceCheck& place, const PlaceCheck::Found& found) { return place.is_right(found, arrival); });
  }
  bool is_shown(size_t tenths, const ImageU8* shown) {
    return judge(tenths, shown, Before::there,
                 [](PlaceCheck& place, const PlaceCheck::Found& found) { return place.is_shown(found); });
  }
  template <class Ask>
  bool judge(size_t tenths, const ImageU8* shown, Before before, Ask ask) {
    PlaceCheck place(options, Subject::stream);
    TrackedFrame frame;
    frame.start(features, 1, from_seconds(0.1));
    for (size_t k = 0; k < points.size(); ++k) {
      const Eigen::Vector3d position_w = 2 * camera.pinhole.unproject(features->x[k], features->y[k]);
      if (k % 10 < tenths) frame.set_match(k, points[k], position_w, PointSource::map);
    }
    if (before == Before::there) place.restart_at(frame, 0);
    if (shown) frontend.monocular(shown->view());
    const ImageProbe probe = frontend.probe();
    const std::vector<uint8_t> in_view(local_map.points.size(), 1);
    return ask(place, {frame, local_map, in_view, &shared, shown ? &probe : nullptr});
  }

  static constexpr size_t kAll = 10, kEnough = 7, kFew = 1;  // tenths
  const Camera camera = camera_for(kWidth, kHeight);
  const ImageU8 image = texture(kWidth, kHeight, 3), other = texture(kWidth, kHeight, 4);
  Frontend frontend{camera, {}, Sensor::monocular};
  RecoveryOptions options;
  SharedMap shared;
  FeaturesPtr features;
  std::vector<MapPointId> points;
  LocalMap local_map;
};

TEST_F(ShownPlaceTest, WhereFewMatchTheImageBearsOutAPlace) {
  for (const auto& [before, arrival] :
       {std::pair{Before::there, Arrival::tracked}, std::pair{Before::there, Arrival::relocalised},
        std::pair{Before::elsewhere, Arrival::relocalised}}) {
    EXPECT_FALSE(is_right(kFew, nullptr, before, arrival));
    EXPECT_FALSE(is_right(kFew, &other, before, arrival));
    EXPECT_TRUE(is_right(kFew, &image, before, arrival));
  }
}

TEST_F(ShownPlaceTest, TheImageAloneBearsOutNoJumpWithoutALoss) {
  for (const Arrival arrival : {Arrival::tracked, Arrival::recognised}) {
    EXPECT_FALSE(is_right(kFew, &image, Before::elsewhere, arrival));
    EXPECT_TRUE(is_right(kEnough, &image, Before::elsewhere, arrival));
  }
}

TEST_F(ShownPlaceTest, APlaceIsShownHoweverFewMatch) {
  EXPECT_TRUE(is_shown(kFew, &image));
  EXPECT_FALSE(is_shown(kFew, &other));
  EXPECT_FALSE(is_shown(kAll, nullptr)) << "there is no image to show it";
}

TEST_F(ShownPlaceTest, TheImageRefutesAJumpThatEnoughMatchesBearOut) {
  for (const Arrival arrival : {Arrival::tracked, Arrival::recognised, Arrival::relocalised}) {
    EXPECT_TRUE(is_right(kEnough, nullptr, Before::elsewhere, arrival));
    EXPECT_FALSE(is_right(kEnough, &other, Before::elsewhere, arrival));
    EXPECT_TRUE(is_right(kEnough, &other, Before::there, arrival)) << "no jump";
  }
}

TEST_F(ShownPlaceTest, LessHasToBeShownTheMoreMatch) {
  ImageU8 mixed(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    std::copy_n(other.row(y), kWidth / 3, mixed.row(y));
    std::copy(image.row(y) + kWidth / 3, image.row(y) + kWidth, mixed.row(y) + kWidth / 3);
  }
  EXPECT_TRUE(is_right(kAll, &mixed, Before::elsewhere, Arrival::tracked));
  EXPECT_FALSE(is_right(kEnough, &mixed, Before::elsewhere, Arrival::tracked));
}

TEST_F(ShownPlaceTest, ImagesAreNotAskedWhereAllWouldHaveToBeShown) {
  options.min_shown_share = 1;
  EXPECT_FALSE(is_right(kFew, &image, Before::there, Arrival::relocalised));
  EXPECT_TRUE(is_right(kEnough, &other, Before::elsewhere, Arrival::relocalised));
}

}  // namespace
}  // namespace covis
