// SPDX-License-Identifier: Apache-2.0
// Tracking allocates nothing in the steady state: every operator new of the process is counted, by thread. (Eigen
// allocates large dynamic matrices by malloc, which is not counted.)
#include <gtest/gtest.h>

#include "covis/core/test_allocations.h"
#include "rendered.h"

namespace covis {
namespace {

// In the first five seconds frames are compared for what their depth is worth, which allocates.
void begin_long_before(Recording& recording, System& system) {
  System::Input first = recording.frame(0);
  first.stamp -= from_seconds(10);
  first.frame = -1;
  system.process(first);
}

class Allocations : public ::testing::TestWithParam<Sensor> {};

// For frames that make no key frame: the tracking thread allocates nothing, and while mapping is idle no thread of the
// system does. One allocation is allowed for the list in which a report returns the results of mapping.
TEST_P(Allocations, TrackingMakesNoneInASteadyState) {
  constexpr int kFrames = 150, kWarmUp = 60;
  Recording recording(GetParam(), kFrames, 30);
  SystemOptions options = options_for(GetParam());
  // It has its own thread, which may allocate while mapping is idle.
  options.mapper.refine_focal = options.mapper.refine_distortion = options.mapper.register_depth = false;
  System system(recording.synth.camera(), options);
  begin_long_before(recording, system);
  bool mapping = false;  // mapping of a key frame is in progress
  int counted = 0, quiet = 0, key_frames = 0;
  long of_key_frames = 0;
  for (int i = 0; i < kFrames; ++i) {
    const System::Input input = recording.frame(i);
    const long own = own_allocations, all = all_allocations;
    const FrameReport report = system.process(input);
    const long own_made = own_allocations - own, all_made = all_allocations - all;
    const bool applied = !report.mapping.empty();
    if (applied) mapping = false;
    if (i >= kWarmUp) {
      EXPECT_EQ(report.track.state, TrackingState::tracking) << i;
      if (report.track.key_frame) {
        ++key_frames;
        of_key_frames += own_made;
      } else {
        ++counted;
        EXPECT_LE(own_made, applied ? 1 : 0) << "frame " << i;  // the list of reports
        if (!mapping && !applied) {
          ++quiet;
          EXPECT_EQ(all_made, 0) << "frame " << i;
        }
      }
    }
    mapping = mapping || report.track.key_frame;
  }
  EXPECT_GT(quiet, 10);
  RecordProperty("frames", counted);
  RecordProperty("key_frames", key_frames);
  RecordProperty("allocations_of_key_frames", static_cast<int>(of_key_frames));
}

// Such a frame is tracked by its image alone: by features of its own, without depth.
TEST(AllocationsOfNonsense, DepthThatContradictsTheMapMakesNoneEither) {
  constexpr int kFrames = 110, kWrong = 70, kWarmUp = 80;  // the map is blamed after two seconds
  Recording recording(Sensor::rgbd, kFrames, 30);
  SystemOptions options = options_for(Sensor::rgbd);
  options.mapper.refine_focal = options.mapper.refine_distortion = options.mapper.register_depth = false;
  System system(recording.synth.camera(), options);
  begin_long_before(recording, system);
  int counted = 0;
  for (int i = 0; i < kFrames; ++i) {
    System::Input input = recording.frame(i);
    ImageF wrong(input.depth.width, input.depth.height);
    for (int y = 0; y < wrong.height(); ++y) {
      for (int x = 0; x < wrong.width(); ++x) wrong(x, y) = 2 * input.depth(x, y);
    }
    if (i >= kWrong) input.depth = wrong.view();
    const long own = own_allocations;
    const FrameReport report = system.process(input);
    const long own_made = own_allocations - own;
    if (i < kWarmUp || report.track.key_frame) continue;
    ++counted;
    EXPECT_GT(report.track.doubts.depth_contradiction, 0) << "frame " << i;
    EXPECT_LE(own_made, report.mapping.empty() ? 0 : 1) << "frame " << i;
  }
  EXPECT_GT(counted, 10);
}

INSTANTIATE_TEST_SUITE_P(Sensors, Allocations, ::testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd));

}  // namespace
}  // namespace covis
