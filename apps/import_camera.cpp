// SPDX-License-Identifier: Apache-2.0
#include "import_camera.h"

#include <cstdio>
#include <filesystem>
#include <utility>

#include "common.h"
#include "covis/core/atomic_file.h"
#include "covis/core/message_text.h"
#include "covis/exchange/camera_import.h"

namespace covis::app {
namespace {

namespace fs = std::filesystem;

// Writes the files of a pair and prints how they are used.
Result<void> write_pair(const io::SensorPair& pair, const fs::path& out) {
  fs::path files[2];
  for (const auto& [i, sensor] : {std::pair(0, &pair.left), {1, &pair.right}}) {
    files[i] = out.parent_path() / (out.stem().string() + "_cam" + std::to_string(i) + "_sensor.yaml");
    if (auto written = write_atomically(files[i], io::sensor_file_text(*sensor)); !written) return written;
  }
  std::printf(
      "stereo pair     %s and %s: as mav0/cam0/sensor.yaml and mav0/cam1/sensor.yaml of a EuRoC sequence, whose images "
      "are rectified while they are read; %s is the left camera alone\n",
      files[0].c_str(), files[1].c_str(), out.c_str());
  return {};
}

}  // namespace

int import_camera(const std::string& file, const std::string& out) {
  const auto imported = exchange::import_camera(file);
  if (!imported) return fail_with(imported.error());
  std::error_code none;
  if (fs::equivalent(file, out, none)) return fail_with(out + ": --out must be another file than the one that is read");
  const std::string head = "# " + imported->format + ": " + fs::path(file).filename().string() + "\n";
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
