// SPDX-License-Identifier: Apache-2.0
// TUM RGB-D folders (Sturm et al., IROS 2012): rgb.txt and depth.txt, or associations.txt; groundtruth.txt.
#include <algorithm>

#include "covis/io/files.h"
#include "covis/io/recording.h"
#include "covis/io/stamp_pairs.h"

namespace covis::io {
namespace {

struct Listed {
  Timestamp stamp;
  std::string name;  // name as written in the file
  std::filesystem::path file;
};

// Reads rows with `columns / 2` pairs "stamp file".
Result<std::vector<std::vector<Listed>>> read_list(const std::filesystem::path& list, size_t pairs) {
  const auto text = read_text(list);
  if (!text) return tl::unexpected(text.error());
  std::vector<std::vector<Listed>> rows;
  std::string problem;
  for_each_line(*text, [&](std::string_view line, int number) {
    const auto parts = split(line);
    if (parts.size() != 2 * pairs) {
      problem = place(list, number) + ": it must hold " + std::to_string(pairs) + " pair(s) of stamp and file name";
      return false;
    }
    std::vector<Listed> row;
    for (size_t p = 0; p < pairs; ++p) {
      const auto stamp = parse_stamp(parts[2 * p]);
      if (!stamp) {
        problem = place(list, number) + ": '" + std::string(parts[2 * p]) + "' is not a stamp in seconds";
        return false;
      }
      row.push_back({*stamp, std::string(parts[2 * p + 1]), list.parent_path() / parts[2 * p + 1]});
    }
    rows.push_back(std::move(row));
    return true;
  });
  if (!problem.empty()) return fail(problem);
  if (rows.empty()) return fail(list.string() + ": no file is listed in it");
  return rows;
}

std::vector<Timestamp> stamps_of(const std::vector<std::vector<Listed>>& rows) {
  std::vector<Timestamp> stamps;
  for (const auto& row : rows) stamps.push_back(row[0].stamp);
  return stamps;
}

// Reads calibration.txt as in ETH3D: fx fy cx cy, optionally k1 k2 p1 p2 [k3].
Result<Camera> read_calibration(const std::filesystem::path& file) {
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  std::vector<double> v;
  std::string problem;
  for_each_line(*text, [&](std::string_view line, int number) {
    for (const std::string_view part : split(line)) {
      const auto value = parse_double(part);
      if (!value) problem = place(file, number) + ": '" + std::string(part) + "' is not a finite number";
      v.push_back(value.value_or(0));
    }
    return false;  // ends after the first row
  });
  if (!problem.empty()) return fail(problem);
  if (v.size() != 4 && v.size() != 8 && v.size() != 9) {
    return fail(
        file.string() +
        ": the first row must be 'fx fy cx cy', with distortion 'k1 k2 p1 p2' or 'k1 k2 p1 p2 k3' behind it if any");
  }
  if (!(v[0] > 0) || !(v[1] > 0)) return fail(file.string() + ": fx and fy must be positive");
  Camera camera;
  camera.pinhole = {v[0], v[1], v[2], v[3], 0};
  if (v.size() > 4) {
    camera.distortion = Distortion::brown_conrady;
    std::copy(v.begin() + 4, v.end(), camera.coefficients.begin());
  }
  return camera;
}

// Intrinsics from the data set's page for its three cameras (vision.in.tum.de/data/datasets/rgbd-dataset/file_formats).
std::optional<Camera> published_camera(const std::string& folder) {
  const auto make = [](double fx, double fy, double cx, double cy, std::array<double, 5> k) {
    Camera camera;
    camera.width = 640;
    camera.height = 480;
    camera.pinhole = {fx, fy, cx, cy, 0};
    camera.coefficients = k;
    if (k[0] != 0) camera.distortion = Distortion::brown_conrady;
    return camera;
  };
  if (folder.find("freiburg1") != std::string::npos)
    return make(517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633});
  if (folder.find("freiburg2") != std::string::npos)
    return make(520.9, 521.0, 325.1, 249.7, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172});
  if (folder.find("freiburg3") != std::string::npos) return make(535.4, 539.2, 320.1, 247.6, {0, 0, 0, 0, 0});
  return std::nullopt;
}

Result<CameraFile> find_camera(const Request& request) {
  if (request.given) return *request.given;
  if (std::filesystem::exists(request.folder / "camera.yaml")) return load_camera(request.folder / "camera.yaml");
  CameraFile file;
  file.file = request.folder / "calibration.txt";
  if (std::filesystem::exists(file.file)) {
    auto camera = read_calibration(file.file);
    if (!camera) return tl::unexpected(camera.error());
    file.camera = *camera;
    return file;
  }
  if (const auto camera = published_camera(std::filesystem::absolute(request.folder).string())) {
    file.file = "freiburg1, 2 or 3, as published";
    file.camera = *camera;
    return file;
  }
  return tl::unexpected(no_calibration(request.folder, "camera.yaml, calibration.txt"));
}

}  // namespace

Result<Recording> read_tum(const Request& request) {
  const std::filesystem::path& folder = request.folder;
  Recording recording;
  recording.kind = SequenceKind::tum;
  recording.name = "TUM RGB-D folder";
  std::filesystem::path associations;
  for (const char* name : {"associations.txt", "associate.txt", "associated.txt"}) {
    if (associations.empty() && std::filesystem::exists(folder / name)) associations = folder / name;
  }
  const bool has_depth = !associations.empty() || std::filesystem::exists(folder / "depth.txt");
  recording.sensor = request.wanted.value_or(has_depth ? Sensor::rgbd : Sensor::monocular);
  if (recording.sensor == Sensor::stereo)
    return fail(folder.string() + ": a TUM RGB-D folder has no stereo pairs; --sensor must be rgbd or mono");
  if (recording.sensor == Sensor::rgbd && !has_depth) {
    return fail(folder.string() + ": there is neither depth.txt nor associations.txt; without depth use --sensor mono");
  }
  // Associations leave out images without depth, but a monocular run uses all images.
  const bool all_images = recording.sensor == Sensor::monocular && std::filesystem::exists(folder / "rgb.txt");
  if (!associations.empty() && !all_images) {
    const auto rows = read_list(associations, 2);
    if (!rows) return tl::unexpected(rows.error());
    for (const auto& row : *rows) {
      const bool depth_first =
          row[0].name.find("depth") != std::string::npos && row[1].name.find("depth") == std::string::npos;
      const Listed& image = row[depth_first ? 1 : 0];
      recording.frames.push_back({image.stamp, image.file, {}, row[depth_first ? 0 : 1].file});
    }
  } else {
    const auto images = read_list(folder / "rgb.txt", 1);
    if (!images) return tl::unexpected(images.error());
    if (recording.sensor == Sensor::rgbd) {
      const auto depths = read_list(folder / "depth.txt", 1);
      if (!depths) return tl::unexpected(depths.error());
      for (const auto& [i, d] : pair_by_stamps(stamps_of(*images), stamps_of(*depths)))
        recording.frames.push_back({(*images)[i][0].stamp, (*images)[i][0].file, {}, (*depths)[d][0].file});
      if (recording.frames.empty()) {
        return fail(folder.string() +
                    ": no image of rgb.txt has a depth image of depth.txt within 20 ms; are the stamps in seconds?");
      }
      if (recording.frames.size() < images->size()) {
        recording.notes.push_back(std::to_string(images->size() - recording.frames.size()) + " of " +
                                  std::to_string(images->size()) +
                                  " images have no depth image within 20 ms and are left out");
      }
    } else {
      for (const auto& row : *images) recording.frames.push_back({row[0].stamp, row[0].file, {}, {}});
    }
  }
  if (recording.sensor == Sensor::monocular) {
    for (FrameFiles& frame : recording.frames) frame.depth.clear();
  }
  const auto camera = find_camera(request);
  if (!camera) return tl::unexpected(camera.error());
  recording.camera = camera->camera;
  recording.depth_scale = camera->depth_scale > 0 ? camera->depth_scale : 5000;
  recording.calibration = camera->file.string();
  if (std::filesystem::exists(folder / "groundtruth.txt")) recording.truth = Truth{folder / "groundtruth.txt", {}, {}};
  return recording;
}

}  // namespace covis::io
