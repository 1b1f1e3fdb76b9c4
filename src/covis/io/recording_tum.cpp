// SPDX-License-Identifier: Apache-2.0
// TUM RGB-D folders (Sturm et al., IROS 2012): rgb.txt and depth.txt, or associations.txt; groundtruth.txt. Among them
// those of ICL-NUIM (Handa et al., "A benchmark for RGB-D visual odometry, 3D reconstruction and SLAM", ICRA 2014).
#include <algorithm>

#include "covis/io/files.h"
#include "covis/io/listed_images.h"

namespace covis::io {
namespace {

// Reads calibration.txt as in ETH3D: fx fy cx cy, optionally k1 k2 p1 p2 [k3].
Result<Camera> read_calibration(const std::filesystem::path& file) {
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  std::vector<double> v;
  std::string problem;
  for_each_line(*text, [&](std::string_view line, int number) {
    for (const std::string_view part : split(line)) {
      const auto value = parse_double(part);
      if (!value && problem.empty())
        problem = place(file, number) + ": '" + std::string(part) + "' is not a finite number";
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

// Intrinsics from the data set's page for its three cameras (vision.in.tum.de/data/datasets/rgbd-dataset/file_formats),
// and the readout of a Kinect, which the first two are, as measured (docs/notes/053-rolling-shutter.md).
std::optional<Camera> published_camera(const std::string& folder) {
  constexpr double kKinect = 0.025;  // seconds
  const auto make = [](double fx, double fy, double cx, double cy, std::array<double, 5> k, double readout) {
    Camera camera;
    camera.width = 640;
    camera.height = 480;
    camera.pinhole = {fx, fy, cx, cy, 0};
    camera.pinhole.row_time = readout / camera.height;
    camera.coefficients = k;
    if (k[0] != 0) camera.distortion = Distortion::brown_conrady;
    return camera;
  };
  if (folder.find("freiburg1") != std::string::npos)
    return make(517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}, kKinect);
  if (folder.find("freiburg2") != std::string::npos)
    return make(520.9, 521.0, 325.1, 249.7, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}, kKinect);
  if (folder.find("freiburg3") != std::string::npos) return make(535.4, 539.2, 320.1, 247.6, {0, 0, 0, 0, 0}, 0);
  return std::nullopt;
}

bool is_depth_first(const ListedRow& row) {
  return row[0].name.find("depth") != std::string::npos && row[1].name.find("depth") == std::string::npos;
}

// In ICL-NUIM's folders of PNG files associations.txt has numbers of frames in the place of stamps, and depth first.
bool is_icl_nuim(const std::vector<ListedRow>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const ListedRow& row) {
    const bool numbered = row[0].stamp % 1'000'000'000 == 0 && row[0].stamp < Timestamp{1'000'000} * 1'000'000'000;
    return is_depth_first(row) && numbered && row[0].stamp == row[1].stamp;
  });
}

// The data set's page (doc.ic.ac.uk/~ahanda/VaFRIC/iclnuim.html) gives fy as -480, for a y axis that points up. Here
// it points down.
Camera icl_nuim_camera() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.pinhole = {481.2, 480, 319.5, 239.5, 0};
  return camera;
}

// Finds the one file with the ending that ICL-NUIM's truth has.
std::optional<Truth> icl_nuim_truth(const std::filesystem::path& folder, std::vector<std::string>& notes) {
  std::vector<std::filesystem::path> found;
  for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().string().ends_with(".gt.freiburg")) found.push_back(entry.path());
  }
  if (found.size() > 1)
    notes.push_back(std::to_string(found.size()) + " files end in .gt.freiburg; with one it is taken as the truth");
  return found.size() == 1 ? std::optional(Truth{found.front(), {}}) : std::nullopt;
}

// published: the camera of the data set that the folder is known to be of.
Result<CameraFile> find_camera(const Request& request, const std::optional<CameraFile>& published) {
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
  if (published) return *published;
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
  std::optional<CameraFile> published;
  if (!associations.empty() && !all_images) {
    const auto rows = read_listed_images(associations, 2);
    if (!rows) return tl::unexpected(rows.error());
    const bool icl_nuim = is_icl_nuim(*rows);
    for (const auto& row : *rows) {
      const bool depth_first = is_depth_first(row);
      const ListedImage& image = row[depth_first ? 1 : 0];
      const Timestamp stamp = icl_nuim ? image.stamp / kIclNuimRate : image.stamp;
      recording.frames.push_back({stamp, image.file, {}, row[depth_first ? 0 : 1].file});
    }
    if (icl_nuim) {
      recording.name = "ICL-NUIM sequence";
      published = CameraFile{.file = "ICL-NUIM, as published", .camera = icl_nuim_camera()};
      recording.truth = icl_nuim_truth(folder, recording.notes);
    }
  } else if (recording.sensor == Sensor::rgbd) {
    auto frames = pair_with_depth(folder / "rgb.txt", folder / "depth.txt", recording);
    if (!frames) return tl::unexpected(frames.error());
    recording.frames = std::move(*frames);
  } else {
    const auto images = read_listed_images(folder / "rgb.txt", 1);
    if (!images) return tl::unexpected(images.error());
    for (const auto& row : *images) recording.frames.push_back({row[0].stamp, row[0].file, {}, {}});
  }
  if (recording.sensor == Sensor::monocular) {
    for (FrameFiles& frame : recording.frames) frame.depth.clear();
  }
  const auto camera = find_camera(request, published);
  if (!camera) return tl::unexpected(camera.error());
  take_camera(*camera, 5000, recording);
  if (!recording.truth && std::filesystem::exists(folder / "groundtruth.txt"))
    recording.truth = Truth{folder / "groundtruth.txt", {}};
  return recording;
}

}  // namespace covis::io
