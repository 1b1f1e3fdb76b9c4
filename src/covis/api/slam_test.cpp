// SPDX-License-Identifier: Apache-2.0
// Calls that the public interface accepts and refuses, without rendered images (those are in tests/api_test.cpp).
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
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

SlamOptions options_of(SensorType sensor) { return {.sensor = sensor, .camera = kCamera}; }

std::string error_of_options(SensorType sensor, void (*change)(SlamOptions&)) {
  SlamOptions options = options_of(sensor);
  change(options);
  return error_of(Slam::create(options));
}

std::string error_of_setting(const std::string& name, const std::string& value) {
  SlamOptions options = options_of(SensorType::rgbd);
  options.settings = {{name, value}};
  return error_of(Slam::create(options));
}

TEST(SlamCreate, AcceptsWhatItMay) {
  for (const SensorType sensor : {SensorType::monocular, SensorType::stereo, SensorType::rgbd}) {
    for (const Timing timing : {Timing::realtime, Timing::deterministic}) {
      SlamOptions options = options_of(sensor);
      options.timing = timing;
      EXPECT_EQ(error_of(Slam::create(options)), "");
    }
  }
  EXPECT_EQ(error_of_options(SensorType::monocular, [](SlamOptions& o) { o.camera.baseline = 0; }), "");
  EXPECT_EQ(error_of_options(SensorType::rgbd, [](SlamOptions& o) { o.camera.lens = LensType::brown_conrady; }), "");
  EXPECT_EQ(error_of_setting("orb.features", "500"), "");
}

TEST(SlamCreate, RefusesValuesThatNoEnumHas) {
  const auto refused = [](void (*change)(SlamOptions&)) { return error_of_options(SensorType::rgbd, change); };
  EXPECT_EQ(refused([](SlamOptions& o) { o.sensor = static_cast<SensorType>(7); }),
            "sensor: it must be monocular, stereo or rgbd, not 7");
  EXPECT_THAT(refused([](SlamOptions& o) { o.timing = static_cast<Timing>(-1); }), HasSubstr("timing: "));
  EXPECT_THAT(refused([](SlamOptions& o) { o.mode = static_cast<Mode>(2); }), HasSubstr("mode: "));
  EXPECT_THAT(refused([](SlamOptions& o) { o.camera.lens = static_cast<LensType>(9); }), HasSubstr("camera: lens"));
  auto slam = Slam::create(options_of(SensorType::monocular));
  ASSERT_TRUE(slam);
  EXPECT_THAT(error_of((*slam)->set_mode(static_cast<Mode>(2))), HasSubstr("mode: "));
  const std::vector<uint8_t> pixels(size_t{3} * kWidth * kHeight);
  const GreyImage grey{pixels.data(), kWidth, kHeight, kWidth};
  for (const int64_t stamp : {std::numeric_limits<int64_t>::max(), int64_t{1} << 62, -(int64_t{1} << 62)}) {
    EXPECT_THAT(error_of((*slam)->track({.stamp = stamp, .image = grey})),
                HasSubstr("stamp: it must be less than 2^62 ns"));
  }
  EXPECT_TRUE((*slam)->locate({.stamp = std::numeric_limits<int64_t>::min(), .image = grey})) << "it is not read";
  EXPECT_TRUE((*slam)->track({.stamp = (int64_t{1} << 62) - 1, .image = grey}));
  const ColourImage colour{pixels.data(), kWidth, kHeight, 3 * kWidth, static_cast<ColourOrder>(5)};
  EXPECT_THAT(error_of((*slam)->track({.stamp = 1, .colour = colour})), HasSubstr("order must be rgb or bgr, not 5"));
}

TEST(SlamCreate, RefusesAnImpossibleCamera) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const struct {
    void (*change)(SlamOptions&);
    SensorType sensor;
    const char* message;
  } cases[] = {
      {[](SlamOptions& o) { o.camera.width = 0; }, SensorType::monocular, "camera: width and height"},
      {[](SlamOptions& o) { o.camera.height = 63; }, SensorType::monocular, "width and height"},
      {[](SlamOptions& o) { o.camera.fx = kNaN; }, SensorType::monocular, "fx and fy"},
      {[](SlamOptions& o) { o.camera.fy = -130; }, SensorType::monocular, "fx and fy"},
      {[](SlamOptions& o) { o.camera.cx = kNaN; }, SensorType::rgbd, "cx and cy"},
      {[](SlamOptions& o) { o.camera.cx = o.camera.cy = 0; }, SensorType::rgbd, "cx and cy"},
      {[](SlamOptions& o) { o.camera.cy = 120; }, SensorType::rgbd, "cx and cy"},
      {[](SlamOptions& o) { o.camera.distortion[0] = 0.1; }, SensorType::rgbd, "lens is none"},
      {[](SlamOptions& o) { o.camera.distortion[4] = kNaN; }, SensorType::rgbd, "distortion"},
      {[](SlamOptions& o) { o.camera.baseline = 0; }, SensorType::stereo, "baseline"},
      {[](SlamOptions& o) { o.camera.baseline = -0.1; }, SensorType::rgbd, "baseline"},
      {[](SlamOptions& o) { o.camera.depth_sigma_a = -1; }, SensorType::rgbd, "depth_sigma_a"},
      {[](SlamOptions& o) { o.camera.lens = LensType::kannala_brandt; }, SensorType::stereo, "rectified"},
      {[](SlamOptions& o) { o.camera.readout = 20; }, SensorType::monocular, "camera: the readout in seconds: 20 "},
      {[](SlamOptions& o) { o.camera.readout = -0.3; }, SensorType::stereo, "from -0.2 to 0.2"},
      {[](SlamOptions& o) { o.camera.readout = kNaN; }, SensorType::rgbd, "readout"},
      {[](SlamOptions& o) { o.camera.depth_fx = kNaN; }, SensorType::rgbd, "depth_fx must be from 0.1 to 10 times fx"},
      {[](SlamOptions& o) { o.camera.depth_fx = -1; }, SensorType::rgbd, "depth_fx must be"},
      {[](SlamOptions& o) { o.camera.depth_x = 0.02; }, SensorType::rgbd, "with depth_fx only, which is 0"},
  };
  for (const auto& c : cases) EXPECT_THAT(error_of_options(c.sensor, c.change), HasSubstr(c.message));
}

TEST(SlamCreate, RefusesARightCameraThatIsNone) {
  const struct {
    void (*change)(SlamOptions&);
    const char* message;
  } cases[] = {
      {[](SlamOptions&) {}, ""},
      {[](SlamOptions& o) { o.sensor = SensorType::rgbd; }, "right: only a stereo pair"},
      {[](SlamOptions& o) { o.camera.baseline = 0.1; }, "camera: baseline"},
      {[](SlamOptions& o) { o.right->camera.fx = 0; }, "right: fx and fy"},
      {[](SlamOptions& o) { o.right->camera.width = 200; }, "one size"},
      {[](SlamOptions& o) { o.right->camera.readout = 0.02; }, "right: readout must be 0 or that of the left"},
      {[](SlamOptions& o) { o.right->pose.qw = 0.5; }, "right: pose"},
      {[](SlamOptions& o) { o.right->pose.x = -0.1; }, "to the right"},
  };
  for (const auto& c : cases) {
    SlamOptions options = options_of(SensorType::stereo);
    options.camera.baseline = 0;
    options.camera.lens = LensType::brown_conrady;
    options.right = RightCamera{.camera = options.camera, .pose = {.x = 0.1}};
    c.change(options);
    EXPECT_THAT(error_of(Slam::create(options)), HasSubstr(c.message));
  }
}

TEST(SlamCreate, RefusesABadSettingByItsName) {
  EXPECT_THAT(error_of_setting("orb.feature", "2000"), HasSubstr("orb.features")) << "the nearest there is";
  EXPECT_THAT(error_of_setting("orb.features", "-5"), HasSubstr("orb.features"));
  EXPECT_THAT(error_of_setting("orb.features", "many"), HasSubstr("orb.features"));
  EXPECT_THAT(error_of_setting("tracker.min_usual_share", "0.5"),
              AllOf(HasSubstr("tracker.min_usual_share"), HasSubstr("tracker.min_expected_match_ratio")))
      << "a setting that was renamed";
  EXPECT_THAT(error_of_setting("system.realtime", "true"), HasSubstr("SlamOptions::timing"));
  EXPECT_THAT(error_of_setting("system.localize", "true"), HasSubstr("SlamOptions::mode"));
}

TEST(SlamCreate, RefusesToLocaliseWithoutAMap) {
  EXPECT_THAT(error_of_options(SensorType::rgbd, [](SlamOptions& o) { o.mode = Mode::localisation; }),
              HasSubstr("needs a map"));
}

TEST(SlamCreate, RefusesFilesThatAreNotThere) {
  EXPECT_THAT(error_of_options(SensorType::rgbd, [](SlamOptions& o) { o.vocabulary = "/nowhere.covis-voc"; }),
              HasSubstr("nowhere.covis-voc"));
  EXPECT_THAT(error_of_options(SensorType::rgbd, [](SlamOptions& o) { o.map = "/nowhere.m"; }), HasSubstr("nowhere.m"));
}

TEST(SlamSettings, AreListedWithTheirRangesAndCanBeGivenBack) {
  SlamOptions options = options_of(SensorType::monocular);
  for (const Setting& setting : default_settings()) {
    EXPECT_FALSE(setting.description.empty()) << setting.name;
    options.settings.emplace_back(setting.name, setting.value);
  }
  EXPECT_GT(options.settings.size(), 40u);
  EXPECT_EQ(error_of(Slam::create(options)), "");

  options.settings = {{"orb.features", "700"}};
  const auto slam = Slam::create(options).value();
  const std::vector<Setting> settings = slam->settings();
  const auto features =
      std::find_if(settings.begin(), settings.end(), [](const Setting& s) { return s.name == "orb.features"; });
  ASSERT_NE(features, settings.end());
  EXPECT_EQ(features->value, "700");
  EXPECT_EQ(features->type, SettingType::whole_number);
  EXPECT_GT(features->min, 0);
  EXPECT_GT(features->max, 700);
}

// Images without anything to see.
class SlamCalls : public testing::Test {
 protected:
  static std::unique_ptr<Slam> create(SensorType sensor) { return Slam::create(options_of(sensor)).value(); }
  Frame frame(int64_t stamp, SensorType sensor) const {
    Frame f{.stamp = stamp, .image = image, .right = {}, .depth = {}};
    if (sensor == SensorType::stereo) f.right = image;
    if (sensor == SensorType::rgbd) f.depth = depth;
    return f;
  }

  const std::vector<uint8_t> pixels = std::vector<uint8_t>(size_t{kWidth} * kHeight, 90);
  const std::vector<float> metres = std::vector<float>(size_t{kWidth} * kHeight, 2.0f);
  const GreyImage image{pixels.data(), kWidth, kHeight, kWidth};
  const GreyImage small{pixels.data(), 100, 100, 100};
  const DepthImage depth{metres.data(), kWidth, kHeight, kWidth};
};

TEST_F(SlamCalls, AFrameThatShowsNothingHasAStateAndAReason) {
  const auto slam = create(SensorType::monocular);
  std::vector<Event> events;
  slam->on_event([&](const Event& event) { events.push_back(event); });
  const auto result = slam->track(frame(0, SensorType::monocular));
  ASSERT_TRUE(result) << result.error();
  EXPECT_EQ(result->state, TrackingState::not_initialised);
  EXPECT_FALSE(result->tracked());
  EXPECT_EQ(result->reason, NoPoseReason::few_features);
  EXPECT_FALSE(result->covariance);
  EXPECT_TRUE(slam->tracked_points().empty());
  slam->finish();
  EXPECT_TRUE(slam->trajectory().empty());
  const auto snapshot = slam->snapshot();
  EXPECT_TRUE(snapshot->submaps.empty() && snapshot->key_frames.empty() && snapshot->points.empty());
  const auto located = slam->locate(frame(0, SensorType::monocular));
  ASSERT_TRUE(located) << located.error();
  EXPECT_FALSE(*located);
  EXPECT_THAT(error_of(slam->save_map("/tmp/never_written.m")), HasSubstr("no map to save"));
  EXPECT_THAT(error_of(slam->set_mode(Mode::localisation)), HasSubstr("needs a map"));
  EXPECT_EQ(slam->mode(), Mode::mapping);
  EXPECT_THAT(error_of(slam->load_map("/nowhere.m")), HasSubstr("nowhere.m"));
  EXPECT_THAT(error_of(slam->load_map("")), HasSubstr("empty"));
  EXPECT_TRUE(events.empty());
}

TEST_F(SlamCalls, TheCameraIsTheOneGivenUntilItIsRefined) {
  for (const SensorType sensor : {SensorType::monocular, SensorType::stereo, SensorType::rgbd}) {
    const CameraParameters camera = create(sensor)->camera();
    EXPECT_EQ(camera.width, kWidth);
    EXPECT_GT(camera.fx, 0);
    EXPECT_GT(camera.baseline, 0) << "as it was given, whatever the sensor";
  }
}

TEST_F(SlamCalls, AReadoutThatWasGivenComesBack) {
  SlamOptions options;
  const auto expect_readout = [&](double readout) {
    const auto slam = Slam::create(options);
    ASSERT_TRUE(slam) << slam.error();
    EXPECT_NEAR((*slam)->camera().readout, readout, 1e-12);
    EXPECT_NEAR((*slam)->snapshot()->camera.readout, readout, 1e-12);
    (*slam)->reset();
    EXPECT_NEAR((*slam)->camera().readout, readout, 1e-12);
  };
  for (const SensorType sensor : {SensorType::monocular, SensorType::stereo, SensorType::rgbd}) {
    options = options_of(sensor);
    expect_readout(0);
    options.camera.readout = -0.02;
    expect_readout(-0.02);
    options.settings = {{"tracker.readout", "0.01"}};
    expect_readout(0.01);
  }
  // A pair that is rectified here.
  options = options_of(SensorType::stereo);
  options.camera.baseline = 0;
  options.camera.readout = 0.02;
  options.right = RightCamera{.camera = options.camera, .pose = {.x = 0.1}};
  expect_readout(0.02);
  options.right->camera.readout = 0;
  expect_readout(0.02);
}

TEST_F(SlamCalls, StampsMustRiseUntilAReset) {
  const auto slam = create(SensorType::rgbd);
  const auto track = [&](int64_t stamp) { return error_of(slam->track(frame(stamp, SensorType::rgbd))); };
  EXPECT_EQ(track(-5), "") << "any stamp may be the first";
  EXPECT_THAT(track(-5), HasSubstr("stamps must rise"));
  EXPECT_THAT(track(-6), HasSubstr("stamps must rise"));
  EXPECT_EQ(track(-4), "") << "an error changes nothing";
  slam->reset();
  EXPECT_EQ(track(-5), "");
}

TEST_F(SlamCalls, ImagesOfAnotherSensorAreRefused) {
  const auto mono = create(SensorType::monocular), stereo = create(SensorType::stereo), rgbd = create(SensorType::rgbd);
  EXPECT_THAT(error_of(mono->track(frame(1, SensorType::stereo))), HasSubstr("right: only a stereo pair"));
  EXPECT_THAT(error_of(mono->track(frame(1, SensorType::rgbd))), HasSubstr("depth: only an RGB-D camera"));
  EXPECT_THAT(error_of(stereo->track(frame(1, SensorType::monocular))), HasSubstr("right: the image is empty"));
  EXPECT_THAT(error_of(rgbd->track(frame(1, SensorType::monocular))), HasSubstr("depth: the image is empty"));
  EXPECT_THAT(error_of(rgbd->locate(frame(1, SensorType::stereo))), HasSubstr("right: only a stereo pair"));
  EXPECT_EQ(error_of(mono->track(frame(1, SensorType::monocular))), "") << "the stamp of a refused call is free";
}

TEST_F(SlamCalls, ImagesOfAnotherSizeAreRefusedByTheirName) {
  const auto error = [&](SensorType sensor, const std::function<void(Frame&)>& change) {
    Frame f = frame(1, sensor);
    change(f);
    const auto slam = create(sensor);
    EXPECT_EQ(error_of(slam->track(f)), error_of(slam->locate(f)));
    return error_of(slam->track(f));
  };
  EXPECT_THAT(error(SensorType::monocular, [&](Frame& f) { f.image = small; }),
              HasSubstr("image: the image is empty or is 100x100; the camera is 160x120"));
  EXPECT_THAT(error(SensorType::monocular, [](Frame& f) { f.image = {}; }), HasSubstr("image"));
  EXPECT_THAT(error(SensorType::monocular, [](Frame& f) { f.image.data = nullptr; }), HasSubstr("image"));
  EXPECT_THAT(error(SensorType::monocular, [](Frame& f) { f.image.stride = kWidth - 1; }),
              HasSubstr("image: the stride, 159"));
  EXPECT_THAT(error(SensorType::stereo, [&](Frame& f) { f.image = small; }), HasSubstr("image"));
  EXPECT_THAT(error(SensorType::stereo, [&](Frame& f) { f.right = small; }), HasSubstr("right"));
  EXPECT_THAT(error(SensorType::rgbd, [](Frame& f) { f.depth.height = 100; }), HasSubstr("depth"));
}

TEST(Names, AreTheWordsOfTheirEnums) {
  EXPECT_STREQ(name(Event::Kind::key_frame_made), "key_frame_made");
  EXPECT_STREQ(name(Event::Kind::submaps_joined), "submaps_joined");
  EXPECT_STREQ(name(Event::Kind::found), "found");
}

}  // namespace
}  // namespace covis
