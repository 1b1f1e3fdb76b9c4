// SPDX-License-Identifier: Apache-2.0
// The processor time that each frame of an RGB-D recording takes this thread in C++, to read and to track: for
// bench/python_overhead, which makes the same calls in Python.
//   build/bench/bench/frame_times RECORDING VOCABULARY
// Prints a line for each frame: both times, milliseconds, and the position found, to the last bit.
#include <cstdio>

#include "apps/run/resources.h"
#include "covis/api/convert.h"
#include "covis/covis.h"
#include "covis/io/sequence.h"

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: frame_times RECORDING VOCABULARY\n"), 2;
  const auto recording = covis::io::open_sequence(argv[1], {.sensor = covis::Sensor::rgbd});
  if (!recording) return std::fprintf(stderr, "%s\n", recording.error().message.c_str()), 1;
  const auto slam = covis::Slam::create({.sensor = covis::SensorType::rgbd,
                                         .camera = covis::to_parameters((*recording)->camera()),
                                         .timing = covis::Timing::deterministic,
                                         .vocabulary = argv[2]});
  if (!slam) return std::fprintf(stderr, "%s\n", slam.error().c_str()), 1;
  while (true) {
    const double begin_ms = covis::app::thread_cpu_ms();
    const auto read = (*recording)->next();
    const double read_ms = covis::app::thread_cpu_ms();
    if (!read) return std::fprintf(stderr, "%s\n", read.error().message.c_str()), 1;
    if (!*read) return 0;
    const covis::io::Frame& frame = **read;
    const auto result = (*slam)->track(
        {.stamp = frame.stamp,
         .image = {frame.image.row(0), frame.image.width(), frame.image.height(), frame.image.stride()},
         .depth = {frame.depth.row(0), frame.depth.width(), frame.depth.height(), frame.depth.stride()}});
    const double tracked_ms = covis::app::thread_cpu_ms();
    if (!result) return std::fprintf(stderr, "%s\n", result.error().c_str()), 1;
    std::printf("%.6f %.6f %.17g %.17g %.17g\n", read_ms - begin_ms, tracked_ms - read_ms, result->pose.x,
                result->pose.y, result->pose.z);
  }
}
