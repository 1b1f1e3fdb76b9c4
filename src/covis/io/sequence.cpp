// SPDX-License-Identifier: Apache-2.0
// Opening recordings: recognising the kind, checking what can be checked before decoding.
#include "covis/io/sequence.h"

#include <algorithm>
#include <charconv>

#include "covis/io/recording.h"
#include "covis/io/sequence_sources.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

bool is_number(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

Result<SequenceKind> recognise(const std::string& path) {
  if (is_number(path) && !fs::exists(path)) return SequenceKind::camera;
  if (!fs::exists(path))
    return fail(path + ": it does not exist; a folder, a video file or a camera's number is wanted");
  const fs::path folder(path);
  if (!fs::is_directory(folder)) return SequenceKind::video;
  if (fs::is_directory(folder / "mav0") || fs::is_directory(folder / "cam0")) return SequenceKind::euroc;
  if (fs::is_directory(folder / "image_0") || fs::is_directory(folder / "image_2")) return SequenceKind::kitti;
  if (fs::exists(folder / "rgb.txt") || fs::exists(folder / "associations.txt")) return SequenceKind::tum;
  for (const char* inner : {"", "images", "image", "rgb", "data"}) {
    if (!list_images(folder / inner).empty()) return SequenceKind::images;
  }
  return fail(path +
              ": it is no recording that can be read. A TUM RGB-D folder has rgb.txt (and depth.txt) or "
              "associations.txt, a KITTI sequence has "
              "image_0 (and image_1) and calib.txt, a EuRoC sequence has mav0/cam0, an image folder has images");
}

// Stamps must rise; every file must be there.
Result<void> check_frames(const Recording& recording) {
  const FrameFiles* last = nullptr;
  for (const FrameFiles& frame : recording.frames) {
    if (last && frame.stamp <= last->stamp) {
      return fail(frame.image.string() + ": its stamp " + std::to_string(to_seconds(frame.stamp)) +
                  " s is not later than " + std::to_string(to_seconds(last->stamp)) +
                  " s of the frame before it; stamps must rise");
    }
    last = &frame;
  }
  for (const FrameFiles& frame : recording.frames) {
    for (const fs::path& file : {frame.image, frame.right, frame.depth}) {
      if (!file.empty() && !fs::exists(file)) return fail(file.string() + ": the file is listed but missing");
    }
  }
  return {};
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

}  // namespace

Result<std::unique_ptr<Sequence>> open_sequence(const std::string& path, const SequenceOptions& options) {
  SequenceKind kind = options.kind;
  if (kind == SequenceKind::automatic) {
    const auto found = recognise(path);
    if (!found) return tl::unexpected(found.error());
    kind = *found;
  }
  Request request{path, options.sensor, std::nullopt};
  if (!options.camera_file.empty()) {
    auto camera = load_camera(options.camera_file);
    if (!camera) return tl::unexpected(camera.error());
    request.given = *camera;
  }
  if (kind == SequenceKind::video || kind == SequenceKind::camera) return open_capture(path, kind, request, options);
  if (!fs::is_directory(path)) return fail(path + ": it is not a folder");
  auto recording = kind == SequenceKind::tum     ? read_tum(request)
                   : kind == SequenceKind::kitti ? read_kitti(request)
                   : kind == SequenceKind::euroc ? read_euroc(request)
                                                 : read_images(request);
  if (!recording) return tl::unexpected(recording.error());
  if (auto checked = check_frames(*recording); !checked) return tl::unexpected(checked.error());
  const size_t all = recording->frames.size();
  choose_frames(*recording, options);
  if (recording->frames.empty()) {
    return fail(path + ": it has " + std::to_string(all) + " frames; none is left from frame " +
                std::to_string(options.first) + " on");
  }
  return open_folder(std::move(*recording), options);
}

Result<Trajectory> load_truth(const Sequence& sequence) {
  const std::optional<Truth> truth = sequence.truth();
  if (!truth) return fail("the recording has no truth");
  auto trajectory = read_trajectory(truth->file, TrajectoryFormat::automatic, truth->stamps);
  if (trajectory && truth->T_bc) {
    for (StampedPose& pose : *trajectory) pose.T_wc = pose.T_wc * *truth->T_bc;
  }
  return trajectory;
}

}  // namespace covis::io
