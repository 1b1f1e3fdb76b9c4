// SPDX-License-Identifier: Apache-2.0
// A folder of images, with stamps from a list, from the file names, or from a frame rate.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

#include "covis/core/message_text.h"
#include "covis/io/files.h"
#include "covis/io/image_stamps.h"
#include "covis/io/images.h"
#include "covis/io/output_check.h"
#include "covis/io/recording.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

}  // namespace

bool is_image(const fs::path& file) {
  // Some systems leave hidden files such as "._1.png" beside the images.
  if (file.filename().string().starts_with('.')) return false;
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  for (const char* known : {".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".bmp", ".tif", ".tiff", ".webp"}) {
    if (extension == known) return true;
  }
  return false;
}

namespace {

// Compares names with the numbers in them ordered by value.
bool natural_less(const fs::path& a, const fs::path& b) {
  const std::string s = a.filename().string(), t = b.filename().string();
  size_t i = 0, j = 0;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  while (i < s.size() && j < t.size()) {
    if (digit(s[i]) && digit(t[j])) {
      const size_t si = i, tj = j;
      while (i < s.size() && digit(s[i])) ++i;
      while (j < t.size() && digit(t[j])) ++j;
      std::string_view x(s.data() + si, i - si), y(t.data() + tj, j - tj);
      x.remove_prefix(std::min(x.find_first_not_of('0'), x.size() - 1));
      y.remove_prefix(std::min(y.find_first_not_of('0'), y.size() - 1));
      if (x != y) return x.size() != y.size() ? x.size() < y.size() : x < y;
    } else if (s[i] != t[j]) {
      return s[i] < t[j];
    } else {
      ++i;
      ++j;
    }
  }
  return s.size() - i != t.size() - j ? s.size() - i < t.size() - j : s < t;
}

// Reads stamps from a list beside the images or one folder up, one per row in the first column. Returns an empty list
// if there is no such file.
Result<std::vector<Timestamp>> find_stamps(const fs::path& folder, const fs::path& images, size_t count) {
  for (const fs::path& base : {folder, images}) {
    for (const char* name : {"times.txt", "timestamps.txt", "stamps.txt"}) {
      const fs::path file = base / name;
      if (!fs::exists(file)) continue;
      auto stamps = read_stamps(file);
      if (stamps && stamps->size() != count) {
        return fail(file.string() + ": it has " + std::to_string(stamps->size()) + " stamps for " +
                    std::to_string(count) + " images");
      }
      return stamps;
    }
  }
  return std::vector<Timestamp>{};
}

// Numbers of frames may be as long, but begin with 0.
constexpr size_t kStampDigits = 10;

bool looks_like_stamp(const std::string& name) {
  constexpr std::string_view kDigits = "0123456789";
  for (size_t begin = 0; (begin = name.find_first_of(kDigits, begin)) != name.npos;) {
    const size_t end = std::min(name.find_first_not_of(kDigits, begin), name.size());
    if (end - begin >= kStampDigits && name[begin] != '0') return true;
    begin = end;
  }
  return false;
}

// Returns ascending stamps when every name is a plain number of at least 10 digits. problem: why the names of images
// give none, if they look as if they did.
std::vector<Timestamp> stamps_of_names(const std::vector<fs::path>& images, WholeStamp whole, std::string& problem) {
  std::vector<Timestamp> stamps;
  for (const fs::path& image : images) {
    const std::string name = image.stem().string();
    const bool number_of_frame = name.starts_with('0') && name.find('.') == name.npos;
    const auto stamp = name.size() >= kStampDigits && !number_of_frame ? parse_stamp(name, whole) : std::nullopt;
    const bool falls = stamp && !stamps.empty() && *stamp <= stamps.back();
    if (!stamp || falls) {
      if (looks_like_stamp(name))
        problem = name + (falls ? " is not later than the one before it"
                                : " is no number of seconds, of ms (13 digits), of µs (16) or of ns (19)");
      return {};
    }
    stamps.push_back(*stamp);
  }
  return stamps;
}

// The same with numbers since 1970 or, where frames would come as of no camera, in nanoseconds since a device started.
std::vector<Timestamp> stamps_of_names(const std::vector<fs::path>& images, std::string& problem) {
  const std::vector<Timestamp> of_epoch = stamps_of_names(images, WholeStamp::seconds, problem);
  if (!of_epoch.empty() && come_as_of_camera(of_epoch)) return of_epoch;
  std::string none;
  std::vector<Timestamp> of_device = stamps_of_names(images, WholeStamp::nanoseconds, none);
  if (of_device.empty() || !come_as_of_camera(of_device)) return of_epoch;
  problem.clear();
  return of_device;
}

}  // namespace

Result<std::vector<Timestamp>> stamps_of_images(const fs::path& recording, const fs::path& folder,
                                                const std::vector<fs::path>& images, double rate,
                                                std::vector<std::string>& notes) {
  constexpr double kDefaultRate = 30;
  auto stamps = find_stamps(recording, folder, images.size());
  if (!stamps) return stamps;
  std::string problem;
  if (stamps->empty()) *stamps = stamps_of_names(images, problem);
  if (!stamps->empty()) return stamps;
  const double counted = rate > 0 ? rate : kDefaultRate;
  for (size_t i = 0; i < images.size(); ++i) stamps->push_back(from_seconds(static_cast<double>(i) / counted));
  if (!problem.empty()) {
    notes.push_back("the images' names look like stamps, but " + problem + ": the frames are counted as " +
                    std::to_string(std::lround(counted)) + " Hz");
  }
  return stamps;
}

std::vector<fs::path> list_images(const fs::path& folder) {
  std::vector<fs::path> images;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (!entry.is_regular_file(error) || !is_image(entry.path())) continue;
    // A check or a run whose results are beside the images leaves pictures there.
    if (entry.path().extension() == ".png" && is_marked_picture(entry.path())) continue;
    images.push_back(entry.path());
  }
  std::sort(images.begin(), images.end(), natural_less);
  return images;
}

Error no_calibration(const fs::path& folder, const std::string& looked_for) {
  return {folder.string() + ": no camera calibration found (looked for " + looked_for +
          "). Give one with --camera FILE, a YAML such as:" + std::string(kCameraExample)};
}

Result<CameraFile> camera_of_images(const Request& request, Sensor sensor) {
  if (request.given) return *request.given;
  if (fs::exists(request.folder / "camera.yaml")) return load_camera(request.folder / "camera.yaml");
  if (request.uncalibrated && sensor == Sensor::monocular) return CameraFile{};
  return tl::unexpected(no_calibration(request.folder, "camera.yaml"));
}

void take_camera(const CameraFile& file, double depth_scale, Recording& recording) {
  recording.camera = file.camera;
  recording.bits = file.bits;
  recording.depth_scale = file.depth_scale > 0 ? file.depth_scale : depth_scale;
  recording.calibration = file.file.empty() ? "the first image" : file.file.string();
}

Result<Recording> read_images(const Request& request) {
  Recording recording;
  recording.kind = SequenceKind::images;
  recording.name = "image folder";
  if (request.wanted && *request.wanted != Sensor::monocular) {
    return fail(
        request.folder.string() +
        ": an image folder serves --sensor mono only; stereo wants the KITTI or EuRoC layout, RGB-D the TUM layout");
  }
  fs::path folder = request.folder;
  for (const char* inner : {"images", "image", "rgb", "data"}) {
    if (list_images(folder).empty() && fs::is_directory(request.folder / inner)) folder = request.folder / inner;
  }
  const std::vector<fs::path> images = list_images(folder);
  if (images.empty())
    return fail(request.folder.string() + ": there is no image in it (PNG, JPEG, PGM, BMP, TIFF, WebP)");
  const auto camera = camera_of_images(request, Sensor::monocular);
  if (!camera) return tl::unexpected(camera.error());
  take_camera(*camera, 1, recording);
  const auto stamps = stamps_of_images(request.folder, folder, images, camera->fps, recording.notes);
  if (!stamps) return tl::unexpected(stamps.error());
  for (size_t i = 0; i < images.size(); ++i) recording.frames.push_back({(*stamps)[i], images[i], {}, {}});
  if (fs::exists(request.folder / "groundtruth.txt")) recording.truth = Truth{request.folder / "groundtruth.txt", {}};
  return recording;
}

}  // namespace covis::io
