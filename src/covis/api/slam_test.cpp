// SPDX-License-Identifier: Apache-2.0
// Calls that the public interface accepts and refuses, without rendered images (those are in tests/api_test.cpp).
#include <gmock/gmock.h>

#include <limits>
#include <string>
#include <vector>

#include "covis/covis.h"

namespace covis {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kWidth = 160, kHeight = 120;
constexpr CameraParameters kCamera{
    .width = kWidth, .height = kHeight, .fx = 130, .fy = 130, .cx = 80, .cy = 60, .baseline = 0.1};

// The message, or nothing when there is none.
template <class Result>
std::string error_of(const Result& result) {
  return result ? std::string() : result.error();
}

std::string error_of_camera(void (*change)(CameraParameters&), SensorType sensor) {
  CameraParameters camera = kCamera;
  change(camera);
  return error_of(Slam::create(camera, sensor));
}

std::string error_of_setting(const std::string& name, const std::string& value) {
  return error_of(Slam::create(kCamera, SensorType::rgbd, {{name, value}}));
}

TEST(SlamCreate, AcceptsWhatItMay) {
  for (const SensorType sensor : {SensorType::monocular, SensorType::stereo, SensorType::rgbd})
    EXPECT_EQ(error_of(Slam::create(kCamera, sensor)), "");
  EXPECT_EQ(error_of_camera([](CameraParameters& c) { c.baseline = 0; }, SensorType::monocular), "");
  EXPECT_EQ(error_of_camera([](CameraParameters& c) { c.lens = LensType::brown_conrady; }, SensorType::rgbd), "");
  EXPECT_EQ(error_of_setting("orb.features", "500"), "");
}

TEST(SlamCreate, RefusesAnImpossibleCamera) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const struct {
    void (*change)(CameraParameters&);
    SensorType sensor;
    const char* message;
  } cases[] = {
      {[](CameraParameters& c) { c.width = 0; }, SensorType::monocular, "width and height"},
      {[](CameraParameters& c) { c.height = 63; }, SensorType::monocular, "width and height"},
      {[](CameraParameters& c) { c.fx = kNaN; }, SensorType::monocular, "fx and fy"},
      {[](CameraParameters& c) { c.fy = -130; }, SensorType::monocular, "fx and fy"},
      {[](CameraParameters& c) { c.cx = kNaN; }, SensorType::rgbd, "cx and cy"},
      {[](CameraParameters& c) { c.distortion[4] = kNaN; }, SensorType::rgbd, "distortion"},
      {[](CameraParameters& c) { c.baseline = 0; }, SensorType::stereo, "baseline"},
      {[](CameraParameters& c) { c.baseline = -0.1; }, SensorType::rgbd, "baseline"},
      {[](CameraParameters& c) { c.lens = LensType::kannala_brandt; }, SensorType::stereo, "rectified"},
  };
  for (const auto& c : cases) EXPECT_THAT(error_of_camera(c.change, c.sensor), HasSubstr(c.message));
}

TEST(SlamCreate, RefusesABadSettingByItsName) {
  EXPECT_THAT(error_of_setting("orb.feature", "2000"), HasSubstr("orb.features")) << "the nearest there is";
  EXPECT_THAT(error_of_setting("orb.features", "-5"), HasSubstr("orb.features"));
  EXPECT_THAT(error_of_setting("orb.features", "many"), HasSubstr("orb.features"));
  EXPECT_THAT(error_of_setting("tracker.min_usual_share", "0.5"),
              AllOf(HasSubstr("tracker.min_usual_share"), HasSubstr("tracker.min_expected_match_ratio")))
      << "a setting that was renamed";
}

TEST(SlamCreate, RefusesToLocaliseWithoutAMap) {
  EXPECT_THAT(error_of_setting("system.localize", "true"), AllOf(HasSubstr("system.localize"), HasSubstr("map")));
  EXPECT_EQ(error_of_setting("system.localize", "false"), "");
}

TEST(SlamCreate, RefusesAVocabularyThatIsNotThere) {
  EXPECT_THAT(error_of(Slam::create(kCamera, SensorType::rgbd, {}, "/nowhere.covis-voc")),
              HasSubstr("nowhere.covis-voc"));
}

// Images without anything to see.
class SlamCalls : public testing::Test {
 protected:
  static std::unique_ptr<Slam> create(SensorType sensor) { return std::move(Slam::create(kCamera, sensor).value()); }

  const std::vector<uint8_t> pixels = std::vector<uint8_t>(size_t{kWidth} * kHeight, 90);
  const std::vector<float> metres = std::vector<float>(size_t{kWidth} * kHeight, 2.0f);
  const GreyImage image{pixels.data(), kWidth, kHeight, kWidth};
  const GreyImage small{pixels.data(), 100, 100, 100};
  const DepthImage depth{metres.data(), kWidth, kHeight, kWidth};
};

TEST_F(SlamCalls, AFrameThatShowsNothingHasAStateAndAReason) {
  const auto slam = create(SensorType::monocular);
  const auto result = slam->track_monocular(0, image);
  ASSERT_TRUE(result) << result.error();
  EXPECT_EQ(result->state, TrackingState::not_initialised);
  EXPECT_FALSE(result->tracked);
  EXPECT_FALSE(result->reason.empty());
  slam->finish();
  EXPECT_TRUE(slam->trajectory().empty() && slam->key_frames().empty() && slam->points().empty());
  const auto located = slam->locate_monocular(image);
  ASSERT_TRUE(located) << located.error();
  EXPECT_FALSE(*located);
}

TEST_F(SlamCalls, TheCameraIsTheOneGivenUntilItIsRefined) {
  for (const SensorType sensor : {SensorType::monocular, SensorType::stereo, SensorType::rgbd}) {
    const CameraParameters camera = create(sensor)->camera();
    EXPECT_EQ(camera.width, kWidth);
    EXPECT_GT(camera.fx, 0);
    EXPECT_GT(camera.baseline, 0) << "as it was given, whatever the sensor";
  }
}

TEST_F(SlamCalls, StampsMustRise) {
  const auto slam = create(SensorType::rgbd);
  const auto track = [&](int64_t stamp) { return error_of(slam->track_rgbd(stamp, image, depth)); };
  EXPECT_EQ(track(-5), "") << "any stamp may be the first";
  EXPECT_THAT(track(-5), HasSubstr("stamps must rise"));
  EXPECT_THAT(track(-6), HasSubstr("stamps must rise"));
  EXPECT_EQ(track(-4), "") << "an error changes nothing";
}

TEST_F(SlamCalls, OfAnotherSensorAreRefused) {
  const auto mono = create(SensorType::monocular), stereo = create(SensorType::stereo), rgbd = create(SensorType::rgbd);
  for (const std::string& error :
       {error_of(mono->track_stereo(1, image, image)), error_of(mono->track_rgbd(1, image, depth)),
        error_of(stereo->track_monocular(1, image)), error_of(rgbd->track_monocular(1, image)),
        error_of(mono->locate_stereo(image, image)), error_of(stereo->locate_rgbd(image, depth)),
        error_of(rgbd->locate_monocular(image))})
    EXPECT_THAT(error, HasSubstr("another sensor"));
  EXPECT_EQ(error_of(mono->track_monocular(1, image)), "") << "the stamp of a refused call is free";
}

TEST_F(SlamCalls, ImagesOfAnotherSizeAreRefusedByTheirName) {
  const auto mono = create(SensorType::monocular), stereo = create(SensorType::stereo), rgbd = create(SensorType::rgbd);
  EXPECT_THAT(error_of(mono->track_monocular(1, small)),
              HasSubstr("image is empty or is 100x100; the camera is 160x120"));
  EXPECT_THAT(error_of(mono->track_monocular(1, {})), HasSubstr("image"));
  EXPECT_THAT(error_of(mono->locate_monocular({nullptr, kWidth, kHeight, kWidth})), HasSubstr("image"));
  EXPECT_THAT(error_of(mono->track_monocular(1, {pixels.data(), kWidth, kHeight, kWidth - 1})),
              HasSubstr("image: the stride, 159"));
  EXPECT_THAT(error_of(stereo->track_stereo(1, small, image)), HasSubstr("left"));
  EXPECT_THAT(error_of(stereo->track_stereo(1, image, small)), HasSubstr("right"));
  EXPECT_THAT(error_of(rgbd->track_rgbd(1, image, {metres.data(), 100, 100, 100})), HasSubstr("depth"));
}

TEST(TrackingStateName, IsItsWord) {
  EXPECT_STREQ(name(TrackingState::not_initialised), "not_initialised");
  EXPECT_STREQ(name(TrackingState::tracking), "tracking");
  EXPECT_STREQ(name(TrackingState::lost), "lost");
}

}  // namespace
}  // namespace covis
