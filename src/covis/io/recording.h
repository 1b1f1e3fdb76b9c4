// SPDX-License-Identifier: Apache-2.0
// The frames of a recording's folder, listed before anything is decoded. Each reader converts one layout to this form.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "covis/features/rectification.h"
#include "covis/io/camera_file.h"
#include "covis/io/images.h"
#include "covis/io/sequence.h"

namespace covis::io {

// Names of a frame's images, which are files but for a bag.
struct FrameFiles {
  Timestamp stamp = 0;
  std::string image, right, depth;  // paths; right, depth: empty when the recording has none
};

struct Recording {
  SequenceKind kind = SequenceKind::images;
  Sensor sensor = Sensor::monocular;
  std::vector<FrameFiles> frames;
  Camera camera;            // width and height 0: not known yet, taken from the first image
  std::string calibration;  // source of the camera's calibration, for messages: a file name
  double depth_scale = 1;   // units per metre
  int bits = 16;            // see CameraFile
  std::optional<StereoRectification> rectification;
  std::optional<Truth> truth;
  std::string name;                      // "TUM RGB-D folder"
  std::vector<std::string> notes;        // items that were skipped: see Sequence::notes()
  std::vector<std::string> losses = {};  // those of notes that are of more than a few frames (bad_frames.h)
  // Makes what reads the frames' images. Empty: an ImageReader does. What it makes may be used in several threads, one
  // each.
  std::function<std::unique_ptr<ImageSource>()> images;
};

// When frames that can't be used are left out (bad_frames.h); else they are an error.
enum class BadFrames { passed_over_where_few, passed_over };

// Input of the readers, one per layout. wanted: the sensor asked for, if any. given: the camera file from the command
// line, if any.
struct Request {
  std::filesystem::path folder;
  std::optional<Sensor> wanted;
  std::optional<CameraFile> given;
  bool uncalibrated = false;  // see SequenceOptions
  TopicNames topics = {};     // a bag's
  BadFrames bad_frames = BadFrames::passed_over_where_few;
};
Result<Recording> read_tum(const Request& request);
Result<Recording> read_kitti(const Request& request);
Result<Recording> read_euroc(const Request& request);
Result<Recording> read_tartanair(const Request& request);
Result<Recording> read_openloris(const Request& request);
Result<Recording> read_open3d(const Request& request);
Result<Recording> read_pairs(const Request& request);  // read_open3d() calls it where has_pairs() is true
Result<Recording> read_images(const Request& request);
Result<Recording> read_bag(const Request& request);

// True for a folder with the layout and names of TartanAir.
bool is_tartanair(const std::filesystem::path& folder);
// True for a folder with images in color/, rgb/ or image/ and depth images in depth/ that are those of the images, by
// the layout of Open3D or by their names.
bool is_open3d(const std::filesystem::path& folder);
// True where at least half of a folder's images have depth images beside them, by their names.
bool has_pairs(const std::filesystem::path& folder);

// Lists the image files of a folder in natural order (2 before 10).
std::vector<std::filesystem::path> list_images(const std::filesystem::path& folder);
// Returns the camera that is given, or that of camera.yaml; one without a size, for monocular images, where the request
// takes them uncalibrated.
Result<CameraFile> camera_of_images(const Request& request, Sensor sensor);
// depth_scale: that of the layout, where the camera file has none.
void take_camera(const CameraFile& file, double depth_scale, Recording& recording);
// Returns the error for a missing calibration: it names --camera and shows a minimal file.
Error no_calibration(const std::filesystem::path& folder, const std::string& looked_for);

}  // namespace covis::io
