// SPDX-License-Identifier: Apache-2.0
// Every fault of tests/faults/faults.h on a recording, rendered or in files, one line each: how many frames were sure
// of their pose, how many of those were wrong, how soon the camera was found again, how soon a warning came.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/stored_recording.h"
#include "tests/faults/fault_run.h"

namespace {

using namespace covis;
using namespace covis::faults;

constexpr int kFrames = 180, kStretchStart = 60, kStretchEnd = 84;

void print(const std::string& name, const FaultResult& r) {
  std::printf(
      "%-32s outside %3d of %3d  within %3d of %3d  refused %3d  wrong outside %3d within %3d  found after %3d  sure "
      "after %3d  "
      "in the first map after %3d  warned after %3d  median error %.3f m\n",
      name.c_str(), r.sure_outside, r.outside, r.sure_within, r.within, r.refused, r.wrong_outside, r.wrong_within,
      r.found_after, r.sure_after, r.recovered_after, r.warned_after, r.median_error);
  std::fflush(stdout);
}

// Runs all faults whose name has `only` in it.
void run_faults(GoodRecording& recording, Stretch stretch, const std::string& only, double usual_error) {
  const std::string prefix = std::string(name(recording.sensor())) + ".";
  const auto run = [&](const std::string& name, const Fault& fault, Stretch at) {
    if (name.find(only) != std::string::npos) print(name, run_fault(recording, fault, at, usual_error));
  };
  const int size = recording.size();
  run(prefix + "none", {}, {size, size});
  for (const Fault& fault : stream_faults(recording.sensor())) run(prefix + fault.name, fault, stretch);
  for (const Fault& fault : sensor_faults(recording.sensor())) run(prefix + "always." + fault.name, fault, {0, size});
}

struct Choice {
  bool back = false, small = false;
  std::string camera_file;
  std::string recording = "room", only;
};

void run_stored(const Choice& choice, Sensor sensor) {
  auto recording =
      StoredRecording::read(choice.recording, {.sensor = sensor, .camera_file = choice.camera_file, .count = kFrames});
  if (!recording) return (void)std::printf("%s: %s\n", name(sensor).data(), recording.error().message.c_str());
  const int size = recording->size(), start = size / 3;
  // Real recordings drift, and so does their ground truth.
  const double greatest = run_fault(*recording, {}, {size, size}).greatest_error;
  const double usual_error = std::isfinite(greatest) ? greatest : 0;
  run_faults(*recording, {start, start + std::min(kStretchEnd - kStretchStart, start / 2)}, choice.only, usual_error);
}

void run_rendered(const Choice& choice, Sensor sensor) {
  SynthOptions options;
  options.world = choice.recording;
  options.sensor = name(sensor);
  options.noise = 2;
  options.depth_noise = 1;
  options.fps = 15;
  if (choice.small) options.width = 320, options.height = 240;
  RenderedRecording recording(options, kFrames, choice.back ? std::optional(kStretchEnd - 1) : std::nullopt);
  run_faults(recording, {kStretchStart, kStretchEnd}, choice.only, 0);
}

}  // namespace

constexpr const char* kUsage = R"(
faults [--back] [--small] [WORLD] [PART OF A NAME]      a rendered recording; --back: after the faulty stretch the
                                                        camera goes back the way it came; --small: images of 320x240
faults [--camera FILE] FOLDER [PART OF A NAME]          the first frames of a recording with a ground truth, by every
                                                        sensor that it has
)";

int main(int count, char** arguments) {
  Choice choice;
  std::vector<std::string> names;
  for (int i = 1; i < count; ++i) {
    const std::string argument = arguments[i];
    if (argument == "--back")
      choice.back = true;
    else if (argument == "--small")
      choice.small = true;
    else if (argument == "--camera" && i + 1 < count)
      choice.camera_file = arguments[++i];
    else if (argument.starts_with('-'))
      return std::printf("%s: no such option\n%s", argument.c_str(), kUsage), 2;
    else
      names.push_back(argument);
  }
  if (!names.empty()) choice.recording = names[0];
  if (names.size() > 1) choice.only = names[1];
  const bool stored = std::filesystem::is_directory(choice.recording);
  if (!stored && std::ranges::find(synth_worlds(), choice.recording) == synth_worlds().end())
    return std::printf("%s: neither a folder nor a world of covis synth\n%s", choice.recording.c_str(), kUsage), 2;
  const auto run = stored ? run_stored : run_rendered;
  for (const Sensor sensor : {Sensor::rgbd, Sensor::stereo, Sensor::monocular}) run(choice, sensor);
}
