// SPDX-License-Identifier: Apache-2.0
// KITTI odometry sequences (Geiger et al., CVPR 2012): image_0/1 grey or image_2/3 colour, calib.txt, times.txt.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <tuple>

#include "covis/geometry/camera_check.h"
#include "covis/io/files.h"
#include "covis/io/recording.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

using Projection = std::array<double, 12>;

// Parses the numbers of a row, which follow its name.
Result<Projection> parse_projection(const std::string& where, const std::vector<std::string_view>& parts) {
  if (parts.size() != 13)
    return fail(where + " has " + std::to_string(parts.size() - 1) + " numbers; a projection matrix has 12");
  Projection p{};
  for (size_t k = 0; k < 12; ++k) {
    const auto value = parse_double(parts[k + 1]);
    if (!value) return fail(where + ": '" + std::string(parts[k + 1]) + "' is not a finite number");
    p[k] = *value;
  }
  if (!(p[0] > 0) || !(p[5] > 0)) return fail(where + ": the focal lengths must be positive");
  // A skew, a rotation or another scale would be no camera of rectified images.
  constexpr double kRounding = 1e-6;
  const auto differs = [&](size_t k, double right, double unit) { return std::abs(p[k] - right) > kRounding * unit; };
  for (const auto& [k, right, unit] :
       {std::tuple<size_t, double, double>{1, 0, p[0]}, {4, 0, p[5]}, {8, 0, 1}, {9, 0, 1}, {10, 1, 1}}) {
    if (differs(k, right, unit)) {
      return fail(where + " is not that of a rectified camera, 'fx 0 cx x 0 fy cy y 0 0 1 z': number " +
                  std::to_string(k + 1) + " is " + std::string(parts[k + 1]) + " and must be " +
                  (right > 0 ? "1" : "0"));
    }
  }
  return p;
}

Result<std::map<std::string, Projection>> read_projections(const fs::path& file) {
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  std::map<std::string, Projection> projections;
  std::string problem;
  for_each_line(*text, [&](std::string_view line, int number) {
    const auto parts = split(line);
    std::string name(parts.empty() ? "" : parts[0]);
    if (name.empty() || name.back() != ':' || name.front() != 'P') return true;  // Tr: and other rows are not needed
    name.pop_back();
    const auto projection = parse_projection(place(file, number) + ": " + name, parts);
    if (!projection) {
      problem = projection.error().message;
      return false;
    }
    if (!projections.emplace(name, *projection).second) problem = place(file, number) + ": " + name + " is given twice";
    return problem.empty();
  });
  if (!problem.empty()) return fail(problem);
  return projections;
}

// P = K [I | t]: a point in camera 0 is translated by t.
Eigen::Vector3d translation_of(const Projection& p) {
  return {(p[3] - p[2] * p[11]) / p[0], (p[7] - p[6] * p[11]) / p[5], p[11]};
}

// Says why the two are not those of a rectified pair. Calibrations of KITTI have offsets of some millimetres.
std::optional<std::string> problem_of_projections(const Projection& left, const Projection& right) {
  if (auto problem =
          problem_of_pair({left[0], left[5], left[2], left[6], 0}, {right[0], right[5], right[2], right[6], 0}))
    return problem;
  constexpr double kLargestOffset = 0.05;  // share of the baseline
  const Eigen::Vector3d between = translation_of(right) - translation_of(left);
  const double offset = std::max(std::abs(between.y()), std::abs(between.z()));
  if (offset <= kLargestOffset * std::abs(between.x())) return std::nullopt;
  return "numbers 8 and 12 put the cameras " + std::to_string(between.y()) + " m apart downwards and " +
         std::to_string(between.z()) + " m forwards, at a baseline of " + std::to_string(std::abs(between.x())) +
         " m; those of a rectified pair lie side by side";
}

struct Calibration {
  std::string source;
  Camera camera;
  int bits;
  double fps;  // Hz; 0: not given
  SE3 T_0c;    // maps from the (left) camera of the images to camera 0, whose poses the ground truth gives
};

// Where calib.txt says that a camera is, as seen from camera 0: with it, where there is none or one that can't be read.
SE3 place_of(const fs::path& file, const std::string& camera) {
  const auto projections = fs::exists(file) ? read_projections(file) : std::map<std::string, Projection>();
  if (!projections || !projections->contains(camera)) return {};
  return SE3(Eigen::Matrix3d::Identity(), -translation_of(projections->at(camera)));
}

// left, right: "P0", "P1" or "P2", "P3". bf is computed from the offset between the two.
Result<Calibration> find_calibration(const Request& request, const std::string& left, const std::string& right,
                                     Sensor sensor) {
  const fs::path file = request.folder / "calib.txt";
  if (request.given)
    return Calibration{request.given->file.string(), request.given->camera, request.given->bits, request.given->fps,
                       place_of(file, left)};
  if (!fs::exists(file)) {
    if (!fs::exists(request.folder / "camera.yaml"))
      return tl::unexpected(no_calibration(request.folder, "calib.txt, camera.yaml"));
    const auto loaded = load_camera(request.folder / "camera.yaml");
    if (!loaded) return tl::unexpected(loaded.error());
    return Calibration{loaded->file.string(), loaded->camera, loaded->bits, loaded->fps, {}};
  }
  const auto projections = read_projections(file);
  if (!projections) return tl::unexpected(projections.error());
  const auto found = projections->find(left);
  if (found == projections->end()) return fail(file.string() + ": '" + left + ":' is missing");
  const Projection& p = found->second;
  Calibration result{file.string(), {}, 16, 0, {}};
  result.camera.pinhole = {p[0], p[5], p[2], p[6], 0};
  result.T_0c = SE3(Eigen::Matrix3d::Identity(), -translation_of(p));
  if (sensor != Sensor::stereo) return result;
  const auto q = projections->find(right);
  if (q == projections->end()) return fail(file.string() + ": '" + right + ":' is missing");
  const Projection& other = q->second;
  if (const auto problem = problem_of_projections(p, other))
    return fail(file.string() + ": " + left + " and " + right + ": " + *problem);
  result.camera.pinhole.bf = p[3] - other[3];
  if (!(result.camera.pinhole.bf > 0))
    return fail(file.string() + ": " + right + " is not to the right of " + left + " (see their fourth numbers)");
  return result;
}

// The row of times.txt and of the poses for an image: its position among the images or, when there are fewer images
// than rows (a part of a sequence), the number in its name.
std::optional<size_t> row_of(const fs::path& image, size_t place, size_t images, size_t rows) {
  if (images == rows) return place;
  const std::string name = image.stem().string();
  size_t row = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), row);
  if (error != std::errc() || end != name.data() + name.size() || row >= rows) return std::nullopt;
  return row;
}

Result<void> set_stamps(const fs::path& times, std::vector<FrameFiles>& frames) {
  const auto stamps = read_stamps(times);
  if (!stamps) return tl::unexpected(stamps.error());
  for (size_t i = 0; i < frames.size(); ++i) {
    const auto row = row_of(frames[i].image, i, frames.size(), stamps->size());
    if (!row) {
      return fail(times.string() + ": it has " + std::to_string(stamps->size()) + " stamps for " +
                  std::to_string(frames.size()) + " images; none for " + frames[i].image);
    }
    frames[i].stamp = (*stamps)[*row];
  }
  return {};
}

// Reads poses by the stamps of the frames they are of.
Result<Trajectory> read_poses(const fs::path& poses, const std::vector<FrameFiles>& frames) {
  const auto rows = read_trajectory(poses, TrajectoryFormat::kitti);
  if (!rows) return rows;
  Trajectory trajectory;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (const auto row = row_of(frames[i].image, i, frames.size(), rows->size()))
      trajectory.push_back({frames[i].stamp, (*rows)[*row].T_wc});
  }
  if (trajectory.empty()) {
    return fail(poses.string() + ": it has " + std::to_string(rows->size()) + " rows for " +
                std::to_string(frames.size()) + " images; none for " + frames.front().image);
  }
  return trajectory;
}

// Looks beside the images and in the data set's layout: dataset/poses/06.txt for dataset/sequences/06.
std::optional<Truth> find_truth(const fs::path& folder, const SE3& T_0c, const std::vector<FrameFiles>& frames) {
  std::error_code none;
  const fs::path whole = fs::weakly_canonical(folder, none);
  for (const fs::path& poses :
       {folder / "poses.txt", whole.parent_path().parent_path() / "poses" / (whole.filename().string() + ".txt")}) {
    if (!fs::exists(poses)) continue;
    return Truth{poses, T_0c, [poses, frames] { return read_poses(poses, frames); }};
  }
  if (fs::exists(folder / "groundtruth_tum.txt")) return Truth{folder / "groundtruth_tum.txt", T_0c};
  return std::nullopt;
}

}  // namespace

Result<Recording> read_kitti(const Request& request) {
  const fs::path& folder = request.folder;
  Recording recording;
  recording.kind = SequenceKind::kitti;
  recording.name = "KITTI odometry sequence";
  const bool grey = fs::is_directory(folder / "image_0");
  const fs::path left = folder / (grey ? "image_0" : "image_2"), right = folder / (grey ? "image_1" : "image_3");
  if (!fs::is_directory(left)) return fail(folder.string() + ": there is neither image_0 nor image_2");
  const bool has_right = fs::is_directory(right);
  recording.sensor = request.wanted.value_or(has_right ? Sensor::stereo : Sensor::monocular);
  if (recording.sensor == Sensor::rgbd)
    return fail(folder.string() + ": a KITTI sequence has no depth images; --sensor must be stereo or mono");
  if (recording.sensor == Sensor::stereo && !has_right) {
    return fail(right.string() + ": the folder of right images is missing; without it use --sensor mono");
  }
  const std::vector<fs::path> images = list_images(left);
  if (images.empty()) return fail(left.string() + ": there is no image in it");
  for (const fs::path& image : images) {
    FrameFiles frame;
    frame.image = image.string();
    if (recording.sensor == Sensor::stereo) frame.right = (right / image.filename()).string();
    recording.frames.push_back(std::move(frame));
  }
  const auto calibration = find_calibration(request, grey ? "P0" : "P2", grey ? "P1" : "P3", recording.sensor);
  if (!calibration) return tl::unexpected(calibration.error());
  const fs::path times = folder / "times.txt";
  if (fs::exists(times)) {
    if (auto set = set_stamps(times, recording.frames); !set) return tl::unexpected(set.error());
  } else {
    const double rate = calibration->fps > 0 ? calibration->fps : 10;
    for (size_t i = 0; i < recording.frames.size(); ++i)
      recording.frames[i].stamp = from_seconds(static_cast<double>(i) / rate);
  }
  recording.camera = calibration->camera;
  recording.bits = calibration->bits;
  recording.calibration = calibration->source;
  recording.truth = find_truth(folder, calibration->T_0c, recording.frames);
  return recording;
}

}  // namespace covis::io
