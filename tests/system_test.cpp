// SPDX-License-Identifier: Apache-2.0
// The whole system, threads and all, on rendered recordings with exact truth.
#include "covis/slam/system.h"

#include <gmock/gmock.h>

#include <cstring>
#include <limits>

#include "covis/geometry/alignment.h"
#include "covis/synth/synth.h"

namespace covis {
namespace {

struct Size {
  int width = 320, height = 240;
};

// Rendered frames, kept: rendering is the larger part of a test's time under the sanitizers.
class Recording {
 public:
  explicit Recording(Sensor sensor, int frames, double fps = 8, const std::string& world = "room", Size size = {})
      : synth(make(sensor, world, frames, fps, size)), frames_(static_cast<size_t>(frames)) {}

  int size() const { return static_cast<int>(frames_.size()); }
  System::Input frame(int i) {
    Images& images = frames_[static_cast<size_t>(i)];
    if (images.left.empty()) render(i, images);
    return input(i, images);
  }
  // A lens cap.
  System::Input black(int i) {
    if (black_.left.empty()) render(0, black_);
    for (ImageU8* image : {&black_.left, &black_.right}) {
      if (!image->empty()) std::memset(image->row(0), 0, static_cast<size_t>(image->stride() * image->height()));
    }
    return input(i, black_);
  }

  Synth synth;

 private:
  struct Images {
    ImageU8 left, right;
    ImageF depth;
  };

  static Synth make(Sensor sensor, const std::string& world, int frames, double fps, Size size) {
    SynthOptions options;
    options.world = world;
    options.sensor = sensor == Sensor::monocular ? "mono" : sensor == Sensor::stereo ? "stereo" : "rgbd";
    options.frames = frames;
    options.fps = fps;
    options.width = size.width;
    options.height = size.height;
    options.noise = 2;
    return std::move(Synth::create(options).value());
  }
  void render(int i, Images& images) {
    synth.render(i, images.left, synth.sensor() == Sensor::stereo ? &images.right : nullptr,
                 synth.sensor() == Sensor::rgbd ? &images.depth : nullptr);
  }
  System::Input input(int i, const Images& images) const {
    return {.frame = i,
            .stamp = synth.stamp(i),
            .image = images.left.view(),
            .right = images.right.view(),
            .depth = images.depth.view()};
  }

  std::vector<Images> frames_;
  Images black_;
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
                           return instance.param == Sensor::monocular ? "mono"
                                  : instance.param == Sensor::stereo  ? "stereo"
                                                                      : "rgbd";
                         });

// Tracks the recording and looks at every frame's report and map. `bound` is of the final error, metres.
void expect_tracked(Recording& recording, Sensor sensor, double bound) {
  System system(recording.synth.camera(), options_for(sensor));
  int tracked = 0, mapped = 0;
  for (int i = 0; i < recording.size(); ++i) {
    const FrameReport report = system.process(recording.frame(i));
    tracked += report.track.state == TrackState::tracking;
    mapped += static_cast<int>(report.mapping.size());
    ASSERT_EQ(system.map().read()->check(), "") << "after frame " << i;
    EXPECT_EQ(report.track.state == TrackState::tracking, report.track.reason.empty()) << report.track.reason;
  }
  system.finish();
  EXPECT_GE(tracked, sensor == Sensor::monocular ? recording.size() / 2 : recording.size());
  EXPECT_GT(mapped, 0);
  const auto poses = system.trajectory();
  EXPECT_GE(static_cast<int>(poses.size()), tracked);
  EXPECT_LT(error(poses, recording.synth, sensor == Sensor::monocular), bound);
  EXPECT_LT(error(system.online_trajectory(), recording.synth, sensor == Sensor::monocular), 1.5 * bound);
}

TEST_P(EachSensor, TracksARoom) {
  Recording recording(GetParam(), 32);
  expect_tracked(recording, GetParam(), 0.04);
}

TEST_P(EachSensor, TracksARoomLong) {
  Recording recording(GetParam(), 60, 30, "room", {640, 480});
  expect_tracked(recording, GetParam(), 0.02);
}

TEST_P(EachSensor, TwoRunsGiveTheSameBytes) {
  Recording recording(GetParam(), 32);
  std::string first;
  for (int run = 0; run < 2; ++run) {
    System system(recording.synth.camera(), options_for(GetParam()));
    for (int i = 0; i < recording.size(); ++i) system.process(recording.frame(i));
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
  Recording recording(GetParam(), 24, 12, "desk");
  System system(recording.synth.camera(), options);
  int tracked = 0;
  for (int i = 0; i < recording.size(); ++i) {
    tracked += system.process(recording.frame(i)).track.state == TrackState::tracking;
  }
  system.finish();
  EXPECT_GE(tracked, recording.size() / 3);
  EXPECT_EQ(system.map().read()->check(), "");
}

TEST_P(EachSensor, LossIsAStateWithAReasonAndIsRecoveredFrom) {
  constexpr int kSeen = 24, kBlack = 4, kAfter = 4;
  Recording recording(GetParam(), kSeen + kBlack + kAfter, 15, "desk");
  System system(recording.synth.camera(), options_for(GetParam()));
  int i = 0;
  for (; i < kSeen; ++i) system.process(recording.frame(i));
  const size_t before = system.trajectory().size();
  ASSERT_GT(before, 5u);
  const size_t key_frames = system.map().read()->key_frame_count();
  for (; i < kSeen + kBlack; ++i) {
    const FrameReport report = system.process(recording.black(i));
    EXPECT_EQ(report.track.state, TrackState::lost);
    EXPECT_FALSE(report.track.reason.empty());
  }
  EXPECT_EQ(system.trajectory().size(), before) << "a pose was invented";
  EXPECT_GE(system.map().read()->key_frame_count(), key_frames);
  int recovered = 0;
  for (; i < recording.size(); ++i) {
    recovered += system.process(recording.frame(i)).track.state == TrackState::tracking;
  }
  EXPECT_GE(recovered, kAfter - 1);
  system.finish();
  EXPECT_LT(error(system.trajectory(), recording.synth, GetParam() == Sensor::monocular), 0.02);
}

TEST(System, NothingToSeeIsNotInitialised) {
  for (const Sensor sensor : {Sensor::monocular, Sensor::stereo, Sensor::rgbd}) {
    Recording recording(sensor, 1, 8, "room", {160, 120});
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
  Recording recording(Sensor::stereo, 4, 8, "desk", {160, 120});
  SystemOptions options = options_for(Sensor::stereo);
  options.orb.features = 200;
  options.orb.levels = 3;
  options.tracker.init_features = 60;
  size_t key_frames = 0;
  for (int cycle = 0; cycle < 200; ++cycle) {
    System system(recording.synth.camera(), options);
    for (int i = 0; i < cycle % 5; ++i) system.process(recording.frame(i));
    if (cycle % 2) system.finish();
    key_frames += system.map().read()->key_frame_count();
  }
  EXPECT_GE(key_frames, 160u) << "the mapping thread had nothing to do";
}

}  // namespace
}  // namespace covis
