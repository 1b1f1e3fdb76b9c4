// SPDX-License-Identifier: Apache-2.0
// TartanAir trajectories (Wang et al., "TartanAir: a dataset to push the limits of visual SLAM", IROS 2020), of the
// first and the second version: image_left, image_right, depth_left, pose_left.txt, or the front cameras of the second
// one.
#include <charconv>
#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "covis/io/files.h"
#include "covis/io/npy.h"
#include "covis/io/opencv_picture.h"
#include "covis/io/recording.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

constexpr float kTartanSky = 1000;  // metres; depths from here on are of the sky, which is a sphere around the world
constexpr double kTartanBaseline = 0.25;  // metres

// The names of a version of the data set.
struct TartanLayout {
  const char *left_folder, *right_folder, *depth_folder, *poses;
  std::string left, right, depth;  // the ends of names, behind the frame's number
  int height;                      // pixels; the width is 640
};

const TartanLayout& tartan_layout(const fs::path& folder) {
  static const TartanLayout kFirst{"image_left", "image_right", "depth_left",      "pose_left.txt",
                                   "_left",      "_right",      "_left_depth.npy", 480};
  static const TartanLayout kSecond{
      "image_lcam_front", "image_rcam_front", "depth_lcam_front",      "pose_lcam_front.txt",
      "_lcam_front",      "_rcam_front",      "_lcam_front_depth.png", 640};
  return fs::is_directory(folder / kSecond.left_folder) ? kSecond : kFirst;
}

// Reads depth of 32-bit floats in metres, from an array file or the four channels of a PNG.
class TartanImages : public ImageReader {
 public:
  Result<void> depth(const fs::path& file, double, ImageF& depth) override {
    if (auto read = read_bytes(file, bytes_); !read) return read;
    if (auto read = file.extension() == ".npy" ? parse_npy(file.string(), bytes_, depth) : floats_of(file, depth);
        !read)
      return read;
    for (int y = 0; y < depth.height(); ++y) {
      float* row = depth.row(y);
      for (int x = 0; x < depth.width(); ++x) row[x] = row[x] > 0 && row[x] < kTartanSky ? row[x] : 0.0F;
    }
    return {};
  }

 private:
  Result<void> floats_of(const fs::path& file, ImageF& depth) {
    const auto decoded = decode_image(file.string(), bytes_, cv::IMREAD_UNCHANGED, {}, expected());
    if (!decoded) return tl::unexpected(decoded.error());
    if (decoded->type() != CV_8UC4)
      return fail(file.string() + ": a depth image must have four channels of 8 bits, which hold a 32-bit float");
    depth.resize(decoded->cols, decoded->rows);
    for (int y = 0; y < decoded->rows; ++y)
      std::memcpy(depth.row(y), decoded->ptr(y), static_cast<size_t>(decoded->cols) * sizeof(float));
    return {};
  }

  std::string bytes_;  // contents of the file
};

// Splits "000012_left" into its number; nullopt for another name.
std::optional<size_t> frame_number(const fs::path& image, const std::string& ending) {
  const std::string name = image.stem().string();
  size_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  constexpr size_t kMost = 1'000'000'000;
  if (error != std::errc() || ending != end || number > kMost) return std::nullopt;
  return number;
}

Result<CameraFile> tartan_camera(const Request& request, const TartanLayout& layout) {
  if (request.given) return *request.given;
  if (fs::exists(request.folder / "camera.yaml")) return load_camera(request.folder / "camera.yaml");
  CameraFile published;
  published.file = "TartanAir, as published";
  published.camera.width = 640;
  published.camera.height = layout.height;
  published.camera.pinhole = {320, 320, 320, layout.height / 2.0, 320 * kTartanBaseline};
  published.camera.pinhole.depth_noise = DepthNoise::exact();
  return published;
}

// The stamp of an image is that of its pose: the one at its place or, when there are other images than poses (a part of
// a trajectory), the one that its name has the number of.
Result<std::vector<FrameFiles>> tartan_frames(const fs::path& folder, const TartanLayout& layout, Sensor sensor,
                                              size_t poses) {
  std::vector<FrameFiles> frames;
  const std::vector<fs::path> images = list_images(folder / layout.left_folder);
  if (images.empty()) return fail((folder / layout.left_folder).string() + ": there is no image in it");
  for (const fs::path& image : images) {
    const auto number = frame_number(image, layout.left);
    if (!number) return fail(image.string() + ": its name must be a number and '" + layout.left + "'");
    const std::string name = image.stem().string();
    const std::string digits = name.substr(0, name.size() - layout.left.size());
    const size_t row = images.size() == poses ? frames.size() : *number;
    FrameFiles frame{static_cast<Timestamp>(row) * kTartanAirStep, image.string(), {}, {}};
    if (sensor == Sensor::stereo)
      frame.right = (folder / layout.right_folder / (digits + layout.right + image.extension().string())).string();
    if (sensor == Sensor::rgbd) frame.depth = (folder / layout.depth_folder / (digits + layout.depth)).string();
    frames.push_back(std::move(frame));
  }
  return frames;
}

size_t count_rows(const fs::path& file) {
  size_t rows = 0;
  if (const auto text = read_text(file)) {
    for_each_line(*text, [&](std::string_view, int) {
      ++rows;
      return true;
    });
  }
  return rows;
}

}  // namespace

bool is_tartanair(const fs::path& folder) {
  const TartanLayout& layout = tartan_layout(folder);
  if (!fs::is_directory(folder / layout.left_folder)) return false;
  if (fs::exists(folder / layout.poses) || fs::is_directory(folder / layout.depth_folder)) return true;
  const std::vector<fs::path> images = list_images(folder / layout.left_folder);
  return !images.empty() && frame_number(images.front(), layout.left);
}

Result<Recording> read_tartanair(const Request& request) {
  const fs::path& folder = request.folder;
  const TartanLayout& layout = tartan_layout(folder);
  Recording recording;
  recording.kind = SequenceKind::tartanair;
  recording.name = "TartanAir trajectory";
  if (!fs::is_directory(folder / layout.left_folder))
    return fail(folder.string() + ": there is neither image_left nor image_lcam_front");
  const bool has_right = fs::is_directory(folder / layout.right_folder);
  const bool has_depth = fs::is_directory(folder / layout.depth_folder);
  recording.sensor = request.wanted.value_or(has_depth ? Sensor::rgbd : has_right ? Sensor::stereo : Sensor::monocular);
  if (recording.sensor == Sensor::rgbd && !has_depth)
    return fail((folder / layout.depth_folder).string() +
                ": the folder of depth is missing; without it use --sensor stereo or mono");
  if (recording.sensor == Sensor::stereo && !has_right)
    return fail((folder / layout.right_folder).string() +
                ": the folder of right images is missing; without it use --sensor rgbd or mono");
  const fs::path poses = folder / layout.poses;
  auto frames = tartan_frames(folder, layout, recording.sensor, count_rows(poses));
  if (!frames) return tl::unexpected(frames.error());
  recording.frames = std::move(*frames);
  const auto camera = tartan_camera(request, layout);
  if (!camera) return tl::unexpected(camera.error());
  take_camera(*camera, 1, recording);
  recording.images = [] { return std::make_unique<TartanImages>(); };
  if (fs::exists(poses)) recording.truth = Truth{poses, {}};
  return recording;
}

}  // namespace covis::io
