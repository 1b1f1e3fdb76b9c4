// SPDX-License-Identifier: Apache-2.0
#include "import_camera.h"

#include <array>
#include <cstdio>
#include <filesystem>

#include "common.h"
#include "covis/core/atomic_file.h"
#include "covis/core/message_text.h"
#include "covis/exchange/camera_import.h"
#include "covis/io/output_check.h"

namespace covis::app {
namespace {

namespace fs = std::filesystem;

// The files of the two cameras of a pair, beside `out`.
std::array<fs::path, 2> files_of_pair(const fs::path& out) {
  const auto file = [&](const char* camera) { return out.parent_path() / (out.stem().string() + camera); };
  return {file("_cam0_sensor.yaml"), file("_cam1_sensor.yaml")};
}

// Writes the files of a pair and prints how they are used.
Result<void> write_pair(const io::SensorPair& pair, const fs::path& out) {
  const auto files = files_of_pair(out);
  if (auto written = write_atomically(files[0], io::sensor_file_text(pair.left)); !written) return written;
  if (auto written = write_atomically(files[1], io::sensor_file_text(pair.right)); !written) return written;
  std::printf(
      "stereo pair     %s and %s: as mav0/cam0/sensor.yaml and mav0/cam1/sensor.yaml of a EuRoC sequence, whose images "
      "are rectified while they are read; %s is the left camera alone\n",
      files[0].c_str(), files[1].c_str(), out.c_str());
  return {};
}

Result<void> check_outputs(const std::string& file, const std::string& out, bool pair) {
  auto fits = io::check_output(out, io::OutputKind::camera, {file});
  for (const fs::path& of_pair : files_of_pair(out)) {
    if (fits && pair) fits = io::check_output(of_pair, io::OutputKind::camera, {file});
  }
  return fits;
}

}  // namespace

int import_camera(const std::string& file, const std::string& out) {
  const auto imported = exchange::import_camera(file);
  if (!imported) return fail_with(imported.error());
  if (const auto fits = check_outputs(file, out, imported->pair.has_value()); !fits) return fail_with(fits.error());
  const std::string head = std::string(io::kCameraFile) + "check --import-camera: " + imported->format + ", " +
                           fs::path(file).filename().string() + "\n";
  if (const auto written = write_atomically(out, head + io::camera_text(imported->file)); !written)
    return fail_with(written.error());
  std::printf("read as         %s\n", imported->format.c_str());
  std::printf("camera          %s\n", camera_json(imported->file.camera).dump().c_str());
  if (imported->file.baseline > 0)
    std::printf("baseline        %g m, of a pair that is rectified\n", imported->file.baseline);
  for (const std::string& note : imported->notes) std::printf("note            %s\n", shown(note).c_str());
  if (imported->pair) {
    if (const auto written = write_pair(*imported->pair, out); !written) return fail_with(written.error());
  }
  std::printf("written         %s: for --camera\n", out.c_str());
  return 0;
}

}  // namespace covis::app
