// SPDX-License-Identifier: Apache-2.0
// A live camera through the loop of `covis run`: frames that come too fast, a camera that goes away and comes back
// elsewhere, and Ctrl-C while it is away.
#include <gmock/gmock.h>

#include <optional>

#include "apps/run/run_loop.h"
#include "apps/run/run_summary.h"
#include "covis/io/live_camera.h"
#include "covis/io/test_camera.h"
#include "python/next_frame.h"
#include "rendered.h"

namespace covis {
namespace {

using app::FrameState;
using testing::HasSubstr;

// Shows the next frame when the one before was tracked, so that nothing depends on time.
class Director : public app::RunObserver {
 public:
  explicit Director(Recording& recording) : recording_(recording) {}

  io::TestCamera camera;
  std::atomic<int> stop = 0;
  std::vector<int> shown;  // frame of the recording, by the number that the camera's image got

  void run_begins(const System&) override { go_on(); }
  void frame_tracked(const app::FrameStats&, const io::Frame&, const FrameReport&) override { go_on(); }
  void frame_skipped(const app::FrameStats& stats) override {
    EXPECT_EQ(stats.state, FrameState::camera_gone);
    EXPECT_THAT(stats.reason, HasSubstr("camera 0: it is gone"));
    if (++times_gone_ == 2) stop = SIGINT;
    go_on();
  }
  void loops_changed(const std::vector<view::LoopPaths>&) override {}

 private:
  void go_on() {
    if (stop != 0) return;
    const auto step = static_cast<int>(shown.size());
    if (step == 15) {  // two at once, of which the first is dropped
      show(15);
      show(16);
      camera.wait_until_asked(18);
    } else if (step == 30) {
      go_away(2);
    } else if (step == 41) {
      go_away(-1);
    } else {
      show(step < 30 ? step : step - 11);  // back where it was ten frames before it went
    }
  }
  void show(int frame) {
    shown.push_back(frame);
    camera.show(1 + static_cast<int64_t>(shown.size()) * 66'000'000, recording_.frame(frame).image);
  }
  void go_away(int refusals) {
    shown.push_back(-1);
    camera.go_away(refusals);
  }

  Recording& recording_;
  int times_gone_ = 0;
};

TEST(Live, ACameraThatGoesAndComesBackIsLocatedInItsMap) {
  Recording& recording = shared_recording(Sensor::monocular, 30, 15, "desk");
  Director director(recording);
  io::LiveCamera::Setup setup{
      .name = "0", .camera = recording.synth.camera(), .rate = 15, .options = {.stop = &director.stop}, .retry = {}};
  app::RunRecord record;
  System system(setup.camera, options_for(Sensor::monocular), vocabulary());
  {
    io::LiveCamera camera(director.camera.device(), setup);
    app::PlayOptions play;
    play.stop = &director.stop;
    play.observer = &director;
    play.show_progress = false;
    app::track_all(camera, system, play, record);
    director.camera.unplug_for_good();
  }
  ASSERT_EQ(record.frames.size(), 41u)
      << "41 were shown, and it went twice, of which one is in place of the dropped one";
  EXPECT_TRUE(record.interrupted);
  EXPECT_EQ(record.failure, "");
  EXPECT_EQ(record.frames[29].state, FrameState::camera_gone);
  int back = 0;
  for (size_t i = 30; i < 40; ++i) back += record.frames[i].state == FrameState::tracking;
  EXPECT_GE(back, 9);
  const auto snapshot = system.snapshot();
  EXPECT_EQ(snapshot->submaps.size(), 1u) << "the map stayed";
  const auto truth = [&](int64_t frame) { return recording.synth.T_wc(director.shown[static_cast<size_t>(frame)]); };
  EXPECT_LT(error_to(snapshot->trajectory, truth, true), 0.02);
  const app::RunSummary summary = app::summarise(record, *snapshot, nullptr, 0);
  EXPECT_EQ(summary.frames.all, 39u);
  EXPECT_EQ(summary.frames.dropped, 1);
  EXPECT_EQ(summary.frames.camera_gone, 2u);
}

TEST(Live, APythonProgramsWaitForACameraEndsByASignal) {
  Recording& recording = shared_recording(Sensor::monocular, 30, 15, "desk");
  std::atomic<int> stop = 0;
  std::atomic<int64_t> unreadable = 0;
  io::TestCamera device;
  io::LiveCamera camera(
      device.device(),
      {.name = "0", .camera = recording.synth.camera(), .rate = 15, .options = {.stop = &stop}, .retry = {}});
  int asked = 0;
  const auto third_time = [&asked] { return ++asked >= 3; };
  const auto next = [&] { return python::next_readable(camera, stop, unreadable, third_time); };
  device.show(66'000'000, recording.frame(0).image);
  const auto first = next();
  ASSERT_TRUE(first && *first);
  device.go_away(-1);
  const auto none = next();
  EXPECT_TRUE(none && !*none) << "it waits for the camera until it is interrupted";
  EXPECT_GE(asked, 3);
  EXPECT_EQ(unreadable, 0) << "a camera that is gone is no frame";
  EXPECT_EQ(stop, 0) << "it may be waited for again";
  device.unplug_for_good();
}

}  // namespace
}  // namespace covis
