// SPDX-License-Identifier: Apache-2.0
// The public interface, as a program sees it.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "covis/covis.h"
#include "rendered.h"

namespace covis {
namespace {

using ::testing::HasSubstr;

constexpr const char* kVocabulary = COVIS_SOURCE_DIR "/vocabulary/default.covis-voc";

CameraParameters parameters_of(const Camera& camera, Sensor sensor) {
  CameraParameters p;
  p.width = camera.width;
  p.height = camera.height;
  p.fx = camera.pinhole.fx;
  p.fy = camera.pinhole.fy;
  p.cx = camera.pinhole.cx;
  p.cy = camera.pinhole.cy;
  if (sensor != Sensor::monocular) p.baseline = camera.pinhole.baseline();
  return p;
}

GreyImage grey(const ImageView<const uint8_t>& v) { return {v.data, v.width, v.height, v.stride}; }
DepthImage depth(const ImageView<const float>& v) { return {v.data, v.width, v.height, v.stride}; }

class Api : public testing::TestWithParam<Sensor> {
 protected:
  static SensorType type(Sensor sensor) {
    return sensor == Sensor::monocular ? SensorType::monocular
           : sensor == Sensor::stereo  ? SensorType::stereo
                                       : SensorType::rgbd;
  }
  static auto track(Slam& slam, const System::Input& in) {
    switch (GetParam()) {
      case Sensor::monocular:
        return slam.track_monocular(in.stamp, grey(in.image));
      case Sensor::stereo:
        return slam.track_stereo(in.stamp, grey(in.image), grey(in.right));
      default:
        return slam.track_rgbd(in.stamp, grey(in.image), depth(in.depth));
    }
  }
  static auto locate(Slam& slam, const System::Input& in) {
    switch (GetParam()) {
      case Sensor::monocular:
        return slam.locate_monocular(grey(in.image));
      case Sensor::stereo:
        return slam.locate_stereo(grey(in.image), grey(in.right));
      default:
        return slam.locate_rgbd(grey(in.image), depth(in.depth));
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Sensors, Api, testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd),
                         [](const auto& instance) { return sensor_name(instance.param); });

TEST_P(Api, TracksLocatesAndRefusesWhatDoesNotFit) {
  const Sensor sensor = GetParam();
  Recording recording(sensor, 30, 15, "desk");
  auto slam = Slam::create(parameters_of(recording.synth.camera(), sensor), type(sensor), {}, kVocabulary);
  ASSERT_TRUE(slam) << slam.error();
  const auto early = locate(**slam, recording.frame(0));
  ASSERT_TRUE(early) << early.error();
  EXPECT_FALSE(*early);  // there is no map yet

  int tracked = 0;
  for (int i = 0; i < recording.size(); ++i) {
    const auto result = track(**slam, recording.frame(i));
    ASSERT_TRUE(result) << result.error();
    tracked += result->tracked;
    EXPECT_EQ(result->tracked, result->reason.empty());
  }
  (*slam)->finish();
  EXPECT_GT(tracked, 15);
  EXPECT_GT((*slam)->points().size(), 100u);
  EXPECT_GE((*slam)->key_frames().size(), 1u);
  const auto trajectory = (*slam)->trajectory();
  ASSERT_GE(trajectory.size(), 15u);

  // What was tracked is found again from the image alone, at the same place; a black image is not.
  const auto last = trajectory.back();
  const auto found = locate(**slam, recording.frame(recording.size() - 1));
  ASSERT_TRUE(found && *found);
  const Pose& at = (*found)->pose;
  const double apart = std::hypot(at.x - last.pose.x, at.y - last.pose.y, at.z - last.pose.z);
  EXPECT_LT(apart, 0.03);
  EXPECT_EQ((*found)->map, last.map);
  const auto nowhere = locate(**slam, recording.black(0));
  ASSERT_TRUE(nowhere) << nowhere.error();
  EXPECT_FALSE(*nowhere);

  // Errors change nothing.
  const System::Input again = recording.frame(3);
  EXPECT_THAT(track(**slam, again).error(), HasSubstr("stamps must rise"));
  const GreyImage small{again.image.data, 100, 100, 100};
  EXPECT_THAT(sensor == Sensor::stereo ? (*slam)->locate_stereo(small, small).error()
              : sensor == Sensor::rgbd ? (*slam)->locate_rgbd(small, depth(again.depth)).error()
                                       : (*slam)->locate_monocular(small).error(),
              HasSubstr("is 100x100; the camera is 320x240"));
  EXPECT_THAT(sensor == Sensor::monocular ? (*slam)->locate_stereo(grey(again.image), grey(again.image)).error()
                                          : (*slam)->locate_monocular(grey(again.image)).error(),
              HasSubstr("another sensor"));
  EXPECT_EQ((*slam)->trajectory().size(), trajectory.size());
}

TEST(ApiErrors, SayWhatIsWrong) {
  const CameraParameters good{.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240, .baseline = 0.1};
  const auto error = [](const CameraParameters& camera, SensorType sensor, const Slam::Settings& settings = {},
                        const std::string& vocabulary = {}) {
    const auto made = Slam::create(camera, sensor, settings, vocabulary);
    return made ? std::string() : made.error();
  };
  EXPECT_EQ(error(good, SensorType::rgbd), "");
  CameraParameters c = good;
  c.width = 0;
  EXPECT_THAT(error(c, SensorType::monocular), HasSubstr("width and height"));
  c = good;
  c.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error(c, SensorType::monocular), HasSubstr("fx and fy"));
  c = good;
  c.baseline = 0;
  EXPECT_THAT(error(c, SensorType::stereo), HasSubstr("baseline"));
  EXPECT_EQ(error(c, SensorType::monocular), "");
  c = good;
  c.lens = LensType::brown_conrady;
  EXPECT_THAT(error(c, SensorType::stereo), HasSubstr("rectified"));
  EXPECT_THAT(error(good, SensorType::rgbd, {{"orb.feature", "2000"}}), HasSubstr("orb.features"));
  EXPECT_THAT(error(good, SensorType::rgbd, {{"orb.features", "-5"}}), HasSubstr("orb.features"));
  EXPECT_THAT(error(good, SensorType::rgbd, {}, "/nowhere.covis-voc"), HasSubstr("nowhere.covis-voc"));
}

}  // namespace
}  // namespace covis
