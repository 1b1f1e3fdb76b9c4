// SPDX-License-Identifier: Apache-2.0
// Opening of recordings: recognises the kind and checks all that can be checked before decoding.
#include "covis/io/sequence.h"

#include <algorithm>
#include <tuple>

#include "covis/io/bad_frames.h"
#include "covis/io/bag.h"
#include "covis/io/files.h"
#include "covis/io/recording.h"
#include "covis/io/sequence_sources.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

Result<void> check_options(const SequenceOptions& options) {
  for (const auto& [name, value, least] : {std::tuple{"first", options.first, 0},
                                           {"stride", options.stride, 1},
                                           {"decode_ahead", options.decode_ahead, 1}}) {
    if (value < least)
      return fail(std::string(name) + ": " + std::to_string(value) + " is too small; the least is " +
                  std::to_string(least));
  }
  return {};
}

bool is_number(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// A list or a camera file that is there by name only would be read as none.
Result<void> check_links(const fs::path& folder) {
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    const std::string extension = entry.path().extension().string();
    const bool may_be_read = extension.empty() || extension == ".txt" || extension == ".yaml" || extension == ".csv";
    if (may_be_read && entry.is_symlink(none) && !fs::exists(entry.path(), none))
      return fail(entry.path().string() + ": it is a link to what is not there (" +
                  fs::read_symlink(entry.path(), none).string() + ")");
  }
  return {};
}

std::optional<SequenceKind> kind_of_folder(const fs::path& folder) {
  if (is_bag(folder)) return SequenceKind::bag;
  if (fs::is_directory(folder / "mav0") || fs::is_directory(folder / "cam0")) return SequenceKind::euroc;
  if (fs::is_directory(folder / "image_0") || fs::is_directory(folder / "image_2")) return SequenceKind::kitti;
  if (is_tartanair(folder)) return SequenceKind::tartanair;
  if (fs::exists(folder / "rgb.txt") || fs::exists(folder / "associations.txt")) return SequenceKind::tum;
  if (fs::exists(folder / "color.txt")) return SequenceKind::openloris;
  if (is_open3d(folder) || has_pairs(folder)) return SequenceKind::open3d;
  for (const char* inner : {"", "images", "image", "rgb", "data"}) {
    if (!list_images(folder / inner).empty()) return SequenceKind::images;
  }
  return std::nullopt;
}

// Describes the contents of a folder that is no recording, and names a subfolder that looks like one.
std::string contents(const fs::path& folder) {
  constexpr size_t kMost = 6;
  std::vector<fs::path> entries;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) entries.push_back(entry.path());
  std::sort(entries.begin(), entries.end());
  if (entries.empty()) return "It is empty.";
  std::string text = "It holds";
  for (size_t i = 0; i < std::min(kMost, entries.size()); ++i) {
    text += (i > 0 ? ", " : " ") + entries[i].filename().string() + (fs::is_directory(entries[i]) ? "/" : "");
  }
  text += entries.size() > kMost ? ", … (" + std::to_string(entries.size()) + " entries)." : ".";
  for (const fs::path& entry : entries) {
    if (fs::is_directory(entry) && kind_of_folder(entry))
      return text + " " + entry.string() + " looks like a recording.";
  }
  return text;
}

Result<SequenceKind> recognise(const std::string& path) {
  if (is_number(path) && !fs::exists(path)) return SequenceKind::camera;
  if (!fs::exists(path))
    return fail(path + ": it does not exist; a folder, a bag, a video file or a camera's number is expected");
  if (!fs::is_directory(path)) return is_bag(path) ? SequenceKind::bag : SequenceKind::video;
  if (const auto kind = kind_of_folder(path)) return *kind;
  return fail(path +
              ": it is no recording that can be read. A TUM RGB-D folder has rgb.txt (and depth.txt) or "
              "associations.txt, a KITTI sequence has image_0 (and image_1) and calib.txt, a EuRoC sequence has "
              "mav0/cam0, a TartanAir trajectory image_left and pose_left.txt, an OpenLORIS-Scene sequence color.txt, "
              "an RGB-D image folder color (or rgb) and depth, or images N.color and N.depth, a ROS 2 bag "
              "metadata.yaml, an image "
              "folder images. " +
              contents(path));
}

void choose_frames(Recording& recording, const SequenceOptions& options) {
  std::vector<FrameFiles>& frames = recording.frames;
  std::vector<FrameFiles> chosen;
  for (auto i = static_cast<size_t>(options.first); i < frames.size(); i += static_cast<size_t>(options.stride)) {
    if (options.count >= 0 && static_cast<int64_t>(chosen.size()) >= options.count) break;
    chosen.push_back(frames[i]);
  }
  frames = std::move(chosen);
}

Result<Recording> read_folder(SequenceKind kind, const Request& request) {
  switch (kind) {
    case SequenceKind::tum:
      return read_tum(request);
    case SequenceKind::kitti:
      return read_kitti(request);
    case SequenceKind::euroc:
      return read_euroc(request);
    case SequenceKind::tartanair:
      return read_tartanair(request);
    case SequenceKind::openloris:
      return read_openloris(request);
    case SequenceKind::open3d:
      return read_open3d(request);
    case SequenceKind::bag:
      return read_bag(request);
    default:
      return read_images(request);
  }
}

Result<std::unique_ptr<Sequence>> open(const std::string& path, const SequenceOptions& options) {
  if (auto checked = check_options(options); !checked) return tl::unexpected(checked.error());
  SequenceKind kind = options.kind;
  if (kind == SequenceKind::automatic) {
    const auto found = recognise(path);
    if (!found) return tl::unexpected(found.error());
    kind = *found;
  }
  if (options.topics.any() && kind != SequenceKind::bag)
    return fail(path + ": topics are named for a bag only, and this is none");
  Request request{path,           options.sensor,
                  std::nullopt,   options.uncalibrated,
                  options.topics, options.skip_bad ? BadFrames::passed_over : BadFrames::passed_over_where_few};
  if (!options.camera_file.empty()) {
    auto camera = load_camera(options.camera_file);
    if (!camera) return tl::unexpected(camera.error());
    request.given = *camera;
  }
  if (kind == SequenceKind::video) return open_video(path, request, options);
  if (kind == SequenceKind::camera) return open_camera(path, request, options);
  if (kind != SequenceKind::bag && !fs::is_directory(path)) return fail(path + ": it is not a folder");
  if (auto whole = check_links(path); !whole) return tl::unexpected(whole.error());
  auto recording = read_folder(kind, request);
  if (!recording) return tl::unexpected(recording.error());
  if (auto left = leave_out_bad_frames(*recording, request.bad_frames); !left) return tl::unexpected(left.error());
  const size_t all = recording->frames.size();
  choose_frames(*recording, options);
  if (recording->frames.empty()) {
    return fail(path + ": it has " + std::to_string(all) + " frames; none is left from frame " +
                std::to_string(options.first) + " on");
  }
  return open_folder(std::move(*recording), options);
}

}  // namespace

std::optional<std::string> doubt_about_rate(double rate) {
  if (rate <= 0 || is_rate_of_camera(rate)) return std::nullopt;
  return "the frames come at " + std::to_string(rate) +
         " Hz: are the stamps in seconds, in ms (13 digits), in µs (16) or in ns (19)?";
}

std::optional<std::string> doubt_about_rate(const Sequence& sequence, int stride) {
  const bool is_told = sequence.kind() == SequenceKind::video || sequence.kind() == SequenceKind::camera;
  if (!is_told && sequence.size() < 2) return std::nullopt;
  return doubt_about_rate(sequence.frame_rate() * stride);
}

Result<std::unique_ptr<Sequence>> open_sequence(const std::string& path, const SequenceOptions& options) {
  return without_exceptions(path, [&]() -> Result<std::unique_ptr<Sequence>> {
    try {
      return open(path, options);
    } catch (const fs::filesystem_error& error) {  // a folder without access rights, a name that is too long
      return fail((error.path1().empty() ? path : error.path1().string()) + ": " + error.code().message());
    }
  });
}

Result<Trajectory> load_truth(const Sequence& sequence) {
  const std::optional<Truth> truth = sequence.truth();
  if (!truth) return fail("the recording has no truth");
  auto trajectory = truth->read ? truth->read() : read_trajectory(truth->file);
  if (trajectory && truth->T_bc) {
    for (StampedPose& pose : *trajectory) pose.T_wc = pose.T_wc * *truth->T_bc;
  }
  return trajectory;
}

}  // namespace covis::io
