// SPDX-License-Identifier: Apache-2.0
// The whole system, threads and all, on rendered recordings with exact truth.
#include <gmock/gmock.h>

#include <cstring>
#include <limits>

#include "covis/geometry/alignment.h"
#include "covis/slam/system.h"
#include "covis/synth/synth.h"

namespace covis {
namespace {

struct Recording {
  Synth synth;
  ImageU8 image, right;
  ImageF depth;

  explicit Recording(Sensor sensor, const std::string& world = "room", int frames = 60, int width = 640, int height = 480)
      : synth(make(sensor, world, frames, width, height)) {}

  static Synth make(Sensor sensor, const std::string& world, int frames, int width, int height) {
    SynthOptions options;
    options.world = world;
    options.sensor = sensor == Sensor::monocular ? "mono" : sensor == Sensor::stereo ? "stereo" : "rgbd";
    options.frames = frames;
    options.width = width;
    options.height = height;
    options.noise = 2;
    return std::move(Synth::create(options).value());
  }

  System::Input frame(int i) {
    synth.render(i, image, synth.sensor() == Sensor::stereo ? &right : nullptr,
                 synth.sensor() == Sensor::rgbd ? &depth : nullptr);
    return input(i);
  }
  // A lens cap.
  System::Input black(int i) {
    frame(i);
    std::memset(image.row(0), 0, static_cast<size_t>(image.stride() * image.height()));
    if (!right.empty()) std::memset(right.row(0), 0, static_cast<size_t>(right.stride() * right.height()));
    return input(i);
  }
  System::Input input(int i) {
    return {.frame = i, .stamp = synth.stamp(i), .image = image.view(), .right = right.view(), .depth = depth.view()};
  }
};

SystemOptions options_for(Sensor sensor) {
  SystemOptions options;
  options.sensor = sensor;
  return options;
}

// Root mean square distance to the truth after the best alignment (with scale when monocular), metres.
double error(const std::vector<PoseOfFrame>& poses, const Synth& synth, bool with_scale) {
  std::vector<Eigen::Vector3d> estimate, truth;
  for (const PoseOfFrame& pose : poses) {
    estimate.push_back(pose.T_wc.t());
    truth.push_back(synth.T_wc(static_cast<int>(pose.frame)).t());
  }
  const auto alignment = align(estimate, truth, with_scale);
  return alignment ? alignment->rmse : std::numeric_limits<double>::quiet_NaN();
}

// The bytes of a trajectory: equal only when every bit is.
std::string bytes(const std::vector<PoseOfFrame>& poses) {
  std::string text;
  for (const PoseOfFrame& pose : poses) {
    text.append(reinterpret_cast<const char*>(pose.T_wc.R().data()), sizeof(double) * 9);
    text.append(reinterpret_cast<const char*>(pose.T_wc.t().data()), sizeof(double) * 3);
  }
  return text;
}

class EachSensor : public testing::TestWithParam<Sensor> {};

INSTANTIATE_TEST_SUITE_P(Sensors, EachSensor, testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd),
                         [](const auto& instance) {
                           return instance.param == Sensor::monocular ? "mono" : instance.param == Sensor::stereo ? "stereo" : "rgbd";
                         });

TEST_P(EachSensor, TracksARoom) {
  const Sensor sensor = GetParam();
  Recording recording(sensor);
  System system(recording.synth.camera(), options_for(sensor));
  int tracked = 0, mapped = 0;
  for (int i = 0; i < recording.synth.frames(); ++i) {
    const FrameReport report = system.process(recording.frame(i));
    tracked += report.track.state == TrackState::tracking;
    mapped += static_cast<int>(report.mapping.size());
    ASSERT_EQ(system.map().read()->check(), "") << "after frame " << i;
    if (report.track.state != TrackState::tracking) {
      EXPECT_FALSE(report.track.reason.empty());
    }
  }
  system.finish();
  const int frames = recording.synth.frames();
  EXPECT_GE(tracked, sensor == Sensor::monocular ? frames / 2 : frames);
  EXPECT_GT(mapped, 0);
  const auto poses = system.trajectory();
  EXPECT_GE(static_cast<int>(poses.size()), tracked);
  EXPECT_LT(error(poses, recording.synth, sensor == Sensor::monocular), 0.02);
  EXPECT_LT(error(system.online_trajectory(), recording.synth, sensor == Sensor::monocular), 0.03);
}

TEST_P(EachSensor, TwoRunsGiveTheSameBytes) {
  std::string first;
  for (int run = 0; run < 2; ++run) {
    Recording recording(GetParam(), "desk", 40);
    System system(recording.synth.camera(), options_for(GetParam()));
    for (int i = 0; i < recording.synth.frames(); ++i) system.process(recording.frame(i));
    system.finish();
    const std::string result = bytes(system.trajectory()) + bytes(system.online_trajectory());
    EXPECT_FALSE(result.empty());
    if (run == 0) first = result;
    EXPECT_EQ(result, first);
  }
}

TEST_P(EachSensor, RealTimeTracksToo) {
  SystemOptions options = options_for(GetParam());
  options.realtime = true;
  Recording recording(GetParam(), "room", 40);
  System system(recording.synth.camera(), options);
  int tracked = 0;
  for (int i = 0; i < recording.synth.frames(); ++i) {
    tracked += system.process(recording.frame(i)).track.state == TrackState::tracking;
  }
  system.finish();
  EXPECT_GE(tracked, recording.synth.frames() / 3);
  EXPECT_EQ(system.map().read()->check(), "");
}

TEST_P(EachSensor, LossIsAStateWithAReasonAndIsRecoveredFrom) {
  Recording recording(GetParam(), "room", 50);
  System system(recording.synth.camera(), options_for(GetParam()));
  for (int i = 0; i < 40; ++i) system.process(recording.frame(i));
  const size_t before = system.trajectory().size();
  ASSERT_GT(before, 5u);
  const size_t key_frames = system.map().read()->key_frame_count();
  for (int i = 40; i < 45; ++i) {
    const FrameReport report = system.process(recording.black(i));
    EXPECT_EQ(report.track.state, TrackState::lost);
    EXPECT_FALSE(report.track.reason.empty());
  }
  EXPECT_EQ(system.trajectory().size(), before) << "a pose was invented";
  EXPECT_GE(system.map().read()->key_frame_count(), key_frames);
  int recovered = 0;
  for (int i = 45; i < 50; ++i) recovered += system.process(recording.frame(i)).track.state == TrackState::tracking;
  EXPECT_GE(recovered, 4);
  system.finish();
  EXPECT_LT(error(system.trajectory(), recording.synth, GetParam() == Sensor::monocular), 0.02);
}

TEST(System, NothingToSeeIsNotInitialised) {
  for (const Sensor sensor : {Sensor::monocular, Sensor::stereo, Sensor::rgbd}) {
    Recording recording(sensor, "room", 3);
    System system(recording.synth.camera(), options_for(sensor));
    for (int i = 0; i < 3; ++i) {
      const FrameReport report = system.process(recording.black(i));
      EXPECT_EQ(report.track.state, TrackState::not_initialised);
      EXPECT_FALSE(report.track.reason.empty());
    }
    system.finish();
    EXPECT_TRUE(system.trajectory().empty());
  }
}

TEST(System, StartsAndStopsAtAnyTime) {
  Recording recording(Sensor::stereo, "room", 4, 320, 240);
  SystemOptions options = options_for(Sensor::stereo);
  options.orb.features = 500;
  options.tracker.init_features = 200;
  for (int cycle = 0; cycle < 200; ++cycle) {
    System system(recording.synth.camera(), options);
    for (int i = 0; i < cycle % 5; ++i) system.process(recording.frame(i % 4));
    if (cycle % 2) system.finish();
  }
}

}  // namespace
}  // namespace covis
