// SPDX-License-Identifier: Apache-2.0
// The contents of a folder of images, listed before anything is decoded. Each reader turns one layout into this one
// form.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "covis/io/camera_file.h"
#include "covis/io/rectification.h"
#include "covis/io/sequence.h"

namespace covis::io {

struct FrameFiles {
  Timestamp stamp = 0;
  std::filesystem::path image, right, depth;  // right, depth: empty when there is none
};

struct Recording {
  SequenceKind kind = SequenceKind::images;
  Sensor sensor = Sensor::monocular;
  std::vector<FrameFiles> frames;
  Camera camera;            // width and height 0: not known yet, taken from the first image
  std::string calibration;  // source of the camera's figures, for messages: a file's name
  double depth_scale = 1;   // units a metre
  std::optional<StereoRectification> rectification;
  std::optional<Truth> truth;
  std::string name;                // "TUM RGB-D folder"
  std::vector<std::string> notes;  // files passed over: see Sequence::notes()
};

// Readers of one layout; `wanted`: the sensor asked for, if any; `given`: the camera file given on the command line, if
// any.
struct Request {
  std::filesystem::path folder;
  std::optional<Sensor> wanted;
  std::optional<CameraFile> given;
};
Result<Recording> read_tum(const Request& request);
Result<Recording> read_kitti(const Request& request);
Result<Recording> read_euroc(const Request& request);
Result<Recording> read_images(const Request& request);

// Image files of a folder, in natural order (2 before 10).
std::vector<std::filesystem::path> list_images(const std::filesystem::path& folder);
// The error when nothing gives the camera's figures: names --camera and shows a minimal file.
Error no_calibration(const std::filesystem::path& folder, const std::string& looked_for);
// The virtual baseline of an RGB-D camera without one, metres.
inline constexpr double kVirtualBaseline = 0.08;

}  // namespace covis::io
