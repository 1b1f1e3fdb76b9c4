// SPDX-License-Identifier: Apache-2.0
// Tracking allocates nothing in a steady state: every allocation of the process is counted, by thread.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <new>

#include "rendered.h"

namespace {

thread_local long own_allocations = 0;
std::atomic<long> all_allocations{0};

void* count_and_allocate(size_t n, size_t alignment) {
  ++own_allocations;
  ++all_allocations;
  return alignment > alignof(std::max_align_t)
             ? std::aligned_alloc(alignment, (n + alignment - 1) / alignment * alignment)
             : std::malloc(n);
}

void* allocate_or_throw(size_t n, size_t alignment) {
  if (void* p = count_and_allocate(n, alignment)) return p;
  throw std::bad_alloc();
}

}  // namespace

#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
void* operator new(size_t n) { return allocate_or_throw(n, 0); }
void* operator new(size_t n, std::align_val_t a) { return allocate_or_throw(n, static_cast<size_t>(a)); }
void* operator new(size_t n, const std::nothrow_t&) noexcept { return count_and_allocate(n, 0); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, size_t, std::align_val_t) noexcept { std::free(p); }

namespace covis {
namespace {

class Allocations : public ::testing::TestWithParam<Sensor> {};

// Frames that make no key frame: none by the tracking thread, and, while mapping rests, none by any thread of the
// system. Where the report tells what mapping made of a key frame, that is put into a list: one.
TEST_P(Allocations, TrackingMakesNoneInASteadyState) {
  constexpr int kFrames = 150, kWarmUp = 60;
  Recording recording(GetParam(), kFrames, 30);
  SystemOptions options = options_for(GetParam());
  options.mapper.refine_focal = false;  // a thread of its own, which may allocate while mapping rests
  System system(recording.synth.camera(), options);
  bool mapping = false;  // a key frame is being worked on
  int counted = 0, quiet = 0, key_frames = 0;
  long of_key_frames = 0;
  for (int i = 0; i < kFrames; ++i) {
    const System::Input input = recording.frame(i);
    const long own = own_allocations, all = all_allocations;
    const FrameReport report = system.process(input);
    const long own_made = own_allocations - own, all_made = all_allocations - all;
    const bool taken_over = !report.mapping.empty();
    if (taken_over) mapping = false;
    if (i >= kWarmUp) {
      EXPECT_EQ(report.track.state, TrackState::tracking) << i;
      if (report.track.key_frame) {
        ++key_frames;
        of_key_frames += own_made;
      } else {
        ++counted;
        EXPECT_LE(own_made, taken_over ? 1 : 0) << "frame " << i;  // the list of reports
        if (!mapping && !taken_over) {
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

INSTANTIATE_TEST_SUITE_P(Sensors, Allocations, ::testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd));

}  // namespace
}  // namespace covis
