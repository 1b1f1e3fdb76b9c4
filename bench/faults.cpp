// SPDX-License-Identifier: Apache-2.0
// Every fault of tests/faults/faults.h on a rendered recording, one line each: how many frames were sure of their pose,
// how many of those were wrong, how soon the camera was found again, how soon a warning came.
#include <cstdio>
#include <optional>
#include <string>

#include "tests/faults/fault_run.h"

namespace {

using namespace covis;
using namespace covis::faults;

constexpr int kFrames = 180, kStretchStart = 60, kStretchEnd = 84;

void print(const std::string& name, const FaultResult& r) {
  std::printf(
      "%-32s outside %3d of %3d  within %3d of %3d  refused %3d  wrong outside %3d within %3d  sure after %3d  "
      "in the first map after %3d  warned after %3d  median error %.3f m\n",
      name.c_str(), r.sure_outside, r.outside, r.sure_within, r.within, r.refused, r.wrong_outside, r.wrong_within,
      r.sure_after, r.recovered_after, r.warned_after, r.median_error);
  std::fflush(stdout);
}

}  // namespace

// faults [--back] [--small] [WORLD] [PART OF A NAME]; --back: after the faulty stretch the camera goes back the way it
// came; --small: images of 320x240
int main(int count, char** arguments) {
  const auto flag = [&](const char* name) {
    const bool given = count > 1 && std::string(arguments[1]) == name;
    if (given) --count, ++arguments;
    return given;
  };
  const bool back = flag("--back"), small = flag("--small");
  const std::string only = count > 2 ? arguments[2] : "";
  for (const Sensor sensor : {Sensor::rgbd, Sensor::stereo, Sensor::monocular}) {
    SynthOptions options;
    options.world = count > 1 ? arguments[1] : "room";
    options.sensor = name(sensor);
    options.noise = 2;
    options.depth_noise = 1;
    options.fps = 15;
    if (small) options.width = 320, options.height = 240;
    GoodRecording recording(options, kFrames, back ? std::optional(kStretchEnd - 1) : std::nullopt);
    const std::string prefix = std::string(name(sensor)) + ".";
    const auto wanted = [&](const std::string& name) { return name.find(only) != std::string::npos; };
    if (wanted(prefix + "none")) print(prefix + "none", run_fault(recording, {}, {kFrames, kFrames}));
    for (const Fault& fault : stream_faults(sensor)) {
      const std::string name = prefix + fault.name;
      if (wanted(name)) print(name, run_fault(recording, fault, {kStretchStart, kStretchEnd}));
    }
    for (const Fault& fault : sensor_faults(sensor)) {
      const std::string name = prefix + "always." + fault.name;
      if (wanted(name)) print(name, run_fault(recording, fault, {0, kFrames}));
    }
  }
}
