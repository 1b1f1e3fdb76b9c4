// SPDX-License-Identifier: Apache-2.0
// KITTI odometry sequences (Geiger et al., CVPR 2012): image_0/1 grey or image_2/3 colour, calib.txt, times.txt.
#include <map>

#include "covis/io/files.h"
#include "covis/io/recording.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

using Projection = std::array<double, 12>;

Result<std::map<std::string, Projection>> read_calibration(const fs::path& file) {
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  std::map<std::string, Projection> projections;
  std::string problem;
  for_each_line(*text, [&](std::string_view line, int number) {
    const auto parts = split(line);
    std::string name(parts[0]);
    if (name.empty() || name.back() != ':' || name.front() != 'P') return true;  // Tr: and others are not needed
    name.pop_back();
    const std::string where = file.string() + ":" + std::to_string(number) + ": " + name;
    if (parts.size() != 13) {
      problem = where + " has " + std::to_string(parts.size() - 1) + " numbers; a projection matrix has 12";
      return false;
    }
    Projection p{};
    for (size_t k = 0; k < 12; ++k) {
      const auto value = parse_double(parts[k + 1]);
      if (!value) {
        problem = where + ": '" + std::string(parts[k + 1]) + "' is not a finite number";
        return false;
      }
      p[k] = *value;
    }
    if (!(p[0] > 0) || !(p[5] > 0)) {
      problem = where + ": the focal lengths must be positive";
      return false;
    }
    projections[name] = p;
    return true;
  });
  if (!problem.empty()) return fail(problem);
  return projections;
}

// The camera of P_left; bf from the offset between both.
Result<Camera> find_camera(const Request& request, const std::string& left, const std::string& right, Sensor sensor) {
  if (request.given) {
    Camera camera = request.given->camera;
    if (sensor == Sensor::stereo && !(camera.pinhole.bf > 0))
      return fail("the camera file needs 'baseline' for a stereo pair");
    return camera;
  }
  const fs::path file = request.folder / "calib.txt";
  if (!fs::exists(file)) return tl::unexpected(no_calibration(request.folder, "calib.txt"));
  const auto projections = read_calibration(file);
  if (!projections) return tl::unexpected(projections.error());
  const auto p = projections->find(left);
  if (p == projections->end()) return fail(file.string() + ": '" + left + ":' is missing");
  Camera camera;
  camera.pinhole = {p->second[0], p->second[5], p->second[2], p->second[6], 0};
  if (sensor != Sensor::stereo) return camera;
  const auto q = projections->find(right);
  if (q == projections->end()) return fail(file.string() + ": '" + right + ":' is missing");
  camera.pinhole.bf = p->second[3] - q->second[3];
  if (!(camera.pinhole.bf > 0))
    return fail(file.string() + ": " + right + " is not to the right of " + left + " (their fourth numbers tell)");
  return camera;
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
    frame.image = image;
    if (recording.sensor == Sensor::stereo) {
      frame.right = right / image.filename();
      if (!fs::exists(frame.right))
        return fail(frame.right.string() + ": the right image of " + image.string() + " is missing");
    }
    recording.frames.push_back(std::move(frame));
  }
  const fs::path times = folder / "times.txt";
  if (fs::exists(times)) {
    const auto text = read_text(times);
    if (!text) return tl::unexpected(text.error());
    size_t next = 0;
    std::string problem;
    for_each_line(*text, [&](std::string_view line, int number) {
      const auto stamp = parse_stamp(split(line).front());
      if (!stamp) {
        problem =
            times.string() + ":" + std::to_string(number) + ": '" + std::string(line) + "' is not a stamp in seconds";
        return false;
      }
      if (next < recording.frames.size()) recording.frames[next].stamp = *stamp;
      ++next;
      return true;
    });
    if (!problem.empty()) return fail(problem);
    if (next < recording.frames.size()) {
      return fail(times.string() + ": it has " + std::to_string(next) + " stamps for " +
                  std::to_string(recording.frames.size()) + " images");
    }
  } else {
    for (size_t i = 0; i < recording.frames.size(); ++i)
      recording.frames[i].stamp = static_cast<Timestamp>(i) * 100'000'000;  // 10 Hz
  }
  const auto camera = find_camera(request, grey ? "P0" : "P2", grey ? "P1" : "P3", recording.sensor);
  if (!camera) return tl::unexpected(camera.error());
  recording.camera = *camera;
  if (fs::exists(folder / "poses.txt") && fs::exists(times)) {
    recording.truth = Truth{folder / "poses.txt", times, {}};
  } else if (fs::exists(folder / "groundtruth_tum.txt")) {
    recording.truth = Truth{folder / "groundtruth_tum.txt", {}, {}};
  }
  return recording;
}

}  // namespace covis::io
