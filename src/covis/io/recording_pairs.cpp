// SPDX-License-Identifier: Apache-2.0
// Folders of images and depth images side by side, whose names tell which is which: 7-Scenes (Shotton et al., "Scene
// coordinate regression forests for camera relocalization in RGB-D images", CVPR 2013), BundleFusion and ScanNet have
// frame-000000.color.* and .depth.*, RGB-D Scenes v2 00000-color.png and -depth.png, and Replica, as NICE-SLAM renders
// it, results/frame000000.jpg and results/depth000000.png.
#include <Eigen/Core>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include "covis/io/bad_frames.h"
#include "covis/io/files.h"
#include "covis/io/image_stamps.h"
#include "covis/io/recording.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

constexpr double kMillimetres = 1000, kReplicaScale = 6553.5;  // units per metre

// An image by its name. Those of one frame have one key: "frame-000012." of frame-000012.color.png, "000012" of
// frame000012.jpg.
struct NamedImage {
  enum class Content { colour, depth };
  Content content;
  std::string key;
};

std::optional<NamedImage> parse_name(const fs::path& image) {
  using Content = NamedImage::Content;
  const std::string stem = image.stem().string();
  const auto numbered = [&](const std::string& word) {
    return stem.size() > word.size() && stem.starts_with(word) &&
           stem.find_first_not_of("0123456789", word.size()) == stem.npos;
  };
  for (const auto& [word, content] : {std::pair("color", Content::colour), {"depth", Content::depth}}) {
    const std::string text = word;
    for (const char* separator : {".", "-", "_"}) {
      if (stem.ends_with(separator + text)) return NamedImage{content, stem.substr(0, stem.size() - text.size())};
    }
  }
  if (numbered("frame")) return NamedImage{Content::colour, stem.substr(5)};
  if (numbered("depth")) return NamedImage{Content::depth, stem.substr(5)};
  return std::nullopt;
}

struct PairedImages {
  fs::path folder;
  std::vector<fs::path> images;            // those in colour, in their order
  std::vector<std::string> keys;           // key of each image
  std::map<std::string, fs::path> depths;  // by key

  size_t pairs() const {
    return static_cast<size_t>(
        std::count_if(keys.begin(), keys.end(), [&](const std::string& key) { return depths.contains(key); }));
  }
};

// Lists the images of the recording's folder or, if there are no pairs, of results/.
PairedImages list_pairs(const fs::path& recording) {
  PairedImages found;
  for (const fs::path& folder : {recording, recording / "results"}) {
    found = {.folder = folder, .images = {}, .keys = {}, .depths = {}};
    for (const fs::path& image : list_images(folder)) {
      const auto named = parse_name(image);
      if (!named) continue;
      if (named->content == NamedImage::Content::depth) {
        found.depths[named->key] = image;
      } else {
        found.images.push_back(image);
        found.keys.push_back(named->key);
      }
    }
    if (found.pairs() > 0) break;
  }
  return found;
}

// Parses the 16 numbers of a pose, row by row; nullopt for one that is not known, which has infinite numbers or NaN.
Result<std::optional<SE3>> parse_pose(const std::string& where, const std::vector<std::string_view>& parts) {
  if (parts.size() != 16)
    return fail(where + ": it has " + std::to_string(parts.size()) + " numbers; a pose is a 4x4 matrix");
  std::vector<double> values;
  for (std::string_view part : parts) {
    double& value = values.emplace_back();
    if (part.starts_with('+')) part.remove_prefix(1);
    if (part.find(".#") != part.npos) part = "nan";  // 1.#QNAN and -1.#INF of old Windows libraries
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc() || end != part.data() + part.size())
      return fail(where + ": '" + std::string(part) + "' is not a number");
  }
  if (!std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); }))
    return std::optional<SE3>();
  auto pose = pose_of_matrix(values);
  const bool is_pose = pose && Eigen::Map<const Eigen::RowVector4d>(&values[12]) == Eigen::RowVector4d(0, 0, 0, 1) &&
                       pose->t().cwiseAbs().maxCoeff() <= kFarthestPosition;
  if (!is_pose)
    return fail(where + ": it is no pose; a rotation and a translation in metres, with 0 0 0 1 below, are expected");
  return pose;
}

// A file of truth for each frame that has one: KEYpose.txt, beside the images.
Result<Trajectory> read_pose_files(const std::vector<std::pair<Timestamp, fs::path>>& files) {
  Trajectory trajectory;
  for (const auto& [stamp, file] : files) {
    const auto text = read_text(file);
    if (!text) return tl::unexpected(text.error());
    std::vector<std::string_view> parts;
    for_each_line(*text, [&](std::string_view line, int) {
      for (const std::string_view part : split(line)) parts.push_back(part);
      return true;
    });
    const auto pose = parse_pose(file.string(), parts);
    if (!pose) return tl::unexpected(pose.error());
    if (*pose) trajectory.push_back({stamp, **pose});
  }
  if (trajectory.empty()) return fail(files.front().second.string() + ": neither it nor the other files hold a pose");
  return trajectory;
}

// A row of traj.txt is the pose of the frame with its number.
Result<Trajectory> read_pose_rows(const fs::path& file, const std::map<size_t, Timestamp>& stamp_of) {
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  Trajectory trajectory;
  Result<void> problem;
  size_t row = 0;
  for_each_line(*text, [&](std::string_view line, int number) {
    const auto pose = parse_pose(place(file, number), split(line));
    if (!pose) problem = tl::unexpected(pose.error());
    const auto stamp = stamp_of.find(row++);
    if (pose && *pose && stamp != stamp_of.end()) trajectory.push_back({stamp->second, **pose});
    return problem.has_value();
  });
  if (!problem) return tl::unexpected(problem.error());
  if (trajectory.empty()) return fail(file.string() + ": there is no pose of a frame in it");
  return trajectory;
}

std::optional<Truth> find_pairs_truth(const fs::path& recording, const PairedImages& found,
                                      const std::vector<Timestamp>& stamps) {
  std::vector<std::pair<Timestamp, fs::path>> files;
  std::map<size_t, Timestamp> stamp_of;
  for (size_t i = 0; i < stamps.size(); ++i) {
    const std::string& key = found.keys[i];
    if (const fs::path file = found.folder / (key + "pose.txt"); fs::exists(file)) files.emplace_back(stamps[i], file);
    size_t number = 0;
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), number);
    if (error == std::errc() && end == key.data() + key.size()) stamp_of[number] = stamps[i];
  }
  if (!files.empty()) return Truth{files.front().second, {}, [files] { return read_pose_files(files); }};
  if (const fs::path rows = recording / "traj.txt"; fs::exists(rows) && !stamp_of.empty())
    return Truth{rows, {}, [rows, stamp_of] { return read_pose_rows(rows, stamp_of); }};
  if (fs::exists(recording / "groundtruth.txt")) return Truth{recording / "groundtruth.txt", {}};
  return std::nullopt;
}

}  // namespace

bool has_pairs(const fs::path& folder) {
  const PairedImages found = list_pairs(folder);
  return found.pairs() > 0 && 2 * found.pairs() >= found.images.size();
}

Result<Recording> read_pairs(const Request& request) {
  const PairedImages found = list_pairs(request.folder);
  Recording recording;
  recording.kind = SequenceKind::open3d;
  recording.name = "RGB-D image folder";
  recording.sensor = request.wanted.value_or(Sensor::rgbd);
  if (recording.sensor == Sensor::stereo)
    return fail(request.folder.string() + ": an RGB-D image folder has no stereo pairs; --sensor must be rgbd or mono");
  const auto camera = camera_of_images(request, recording.sensor);
  if (!camera) return tl::unexpected(camera.error());
  const bool replica = found.keys.front().find_first_not_of("0123456789") == std::string::npos;
  take_camera(*camera, replica ? kReplicaScale : kMillimetres, recording);
  const auto stamps = stamps_of_images(request.folder, found.folder, found.images, camera->fps, recording.notes);
  if (!stamps) return tl::unexpected(stamps.error());
  for (size_t i = 0; i < found.images.size(); ++i) {
    const auto depth = found.depths.find(found.keys[i]);
    FrameFiles frame{(*stamps)[i], found.images[i].string(), {}, {}};
    if (recording.sensor == Sensor::rgbd) {
      if (depth == found.depths.end()) continue;
      frame.depth = depth->second.string();
    }
    recording.frames.push_back(std::move(frame));
  }
  if (const size_t all = found.images.size(), left_out = all - recording.frames.size(); left_out > 0)
    note_left_out(left_out, all, "images have no depth image of their name", recording);
  recording.truth = find_pairs_truth(request.folder, found, *stamps);
  return recording;
}

}  // namespace covis::io
