// SPDX-License-Identifier: Apache-2.0
// OpenLORIS-Scene sequences (Shi et al., "Are we ready for service robots? The OpenLORIS-Scene datasets for lifelong
// SLAM", ICRA 2020): the D435i's color.txt and aligned_depth.txt, sensors.yaml, trans_matrix.yaml, groundtruth.txt.
#include <algorithm>
#include <cmath>

#include "covis/io/listed_images.h"
#include "covis/io/sensor_file.h"
#include "covis/io/yaml.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOpenLorisColour = "d400_color";  // the camera's frame, which may have _optical_frame behind it

// Reads the colour camera. Its intrinsics are fx cx fy cy in the data set's files; fx fy cx cy are known by a principal
// point that is nearer to the middle of the image.
Result<Camera> read_openloris_camera(const fs::path& file) {
  const auto root = load_yaml(file);
  if (!root) return tl::unexpected(root.error());
  YAML::Node sensor;
  if (root->IsMap()) {
    for (const auto& entry : *root) {
      if (entry.first.Scalar().starts_with(kOpenLorisColour)) sensor = entry.second;
    }
  }
  if (!sensor.IsMap()) return fail(file.string() + ": '" + kOpenLorisColour + "_optical_frame' is missing");
  const auto k = read_intrinsics(file, sensor);
  if (!k) return tl::unexpected(k.error());
  const auto width = yaml_number(file, sensor, "width"), height = yaml_number(file, sensor, "height");
  if (!width) return tl::unexpected(width.error());
  if (!height) return tl::unexpected(height.error());
  Camera camera;
  for (const auto& [key, side] : {std::pair("width", *width), {"height", *height}}) {
    if (!(side >= 1 && side <= 20000 && side == std::floor(side)))
      return fail(yaml_place(file, sensor[key]) + ": " + key + " must be that of the images, a whole number of pixels");
  }
  camera.width = static_cast<int>(*width);
  camera.height = static_cast<int>(*height);
  const auto off_centre = [&](double cx, double cy) { return std::hypot(cx - *width / 2, cy - *height / 2); };
  const std::vector<double>& v = *k;
  camera.pinhole = off_centre(v[1], v[3]) < off_centre(v[2], v[3]) ? Pinhole{v[0], v[2], v[1], v[3], 0}
                                                                   : Pinhole{v[0], v[1], v[2], v[3], 0};
  if (!(camera.pinhole.fx > 0 && camera.pinhole.fy > 0))
    return fail(file.string() + ": intrinsics: the focal lengths must be positive");
  if (!sensor["distortion_coefficients"]) return camera;
  const auto d = yaml_numbers(file, sensor, "distortion_coefficients", 4);
  if (!d) return tl::unexpected(d.error());
  if (std::all_of(d->begin(), d->end(), [](double value) { return value == 0; })) return camera;
  const std::string model = yaml_text(sensor, "distortion_model", "none");
  if (model.find("brown") == std::string::npos && distortion_named(model) != Distortion::brown_conrady) {
    return fail(file.string() + ": distortion_model '" + model +
                "' with coefficients that are not zero can't be used; give a camera file with --camera");
  }
  camera.distortion = Distortion::brown_conrady;
  const auto coefficients = read_coefficients(file, sensor, "distortion_coefficients", camera.distortion);
  if (!coefficients) return tl::unexpected(coefficients.error());
  camera.coefficients = *coefficients;
  return camera;
}

// The pose of the colour camera in the robot's base, whose poses the truth gives; nullopt: nobody says.
std::optional<SE3> base_to_colour(const fs::path& file) {
  if (!fs::exists(file)) return std::nullopt;
  const auto root = load_yaml(file);
  if (!root || !root->IsMap() || !(*root)["trans_matrix"] || !(*root)["trans_matrix"].IsSequence()) return std::nullopt;
  for (const auto& entry : (*root)["trans_matrix"]) {
    if (yaml_text(entry, "parent_frame", "") != "base_link" ||
        !yaml_text(entry, "child_frame", "").starts_with(kOpenLorisColour))
      continue;
    const auto m = yaml_numbers(file, entry, "matrix", 16);
    if (!m) return std::nullopt;
    Eigen::Matrix4d T;
    for (int i = 0; i < 16; ++i) T(i / 4, i % 4) = (*m)[static_cast<size_t>(i)];
    const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
    if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-3) return std::nullopt;
    return SE3(R, T.topRightCorner<3, 1>()).normalized();
  }
  return std::nullopt;
}

Result<CameraFile> find_openloris_camera(const Request& request) {
  if (request.given) return *request.given;
  if (fs::exists(request.folder / "camera.yaml")) return load_camera(request.folder / "camera.yaml");
  CameraFile found;
  found.file = request.folder / "sensors.yaml";
  if (!fs::exists(found.file)) return tl::unexpected(no_calibration(request.folder, "camera.yaml, sensors.yaml"));
  const auto camera = read_openloris_camera(found.file);
  if (!camera) return tl::unexpected(camera.error());
  found.camera = *camera;
  found.camera.pinhole.depth_noise = DepthNoise::realsense();
  return found;
}

}  // namespace

Result<Recording> read_openloris(const Request& request) {
  const fs::path& folder = request.folder;
  Recording recording;
  recording.kind = SequenceKind::openloris;
  recording.name = "OpenLORIS-Scene sequence";
  const bool has_depth = fs::exists(folder / "aligned_depth.txt");
  recording.sensor = request.wanted.value_or(has_depth ? Sensor::rgbd : Sensor::monocular);
  if (recording.sensor == Sensor::stereo) {
    return fail(folder.string() +
                ": the stereo pair of an OpenLORIS-Scene sequence (fisheye1, fisheye2) can't be read; --sensor must be "
                "rgbd or mono");
  }
  if (recording.sensor == Sensor::rgbd) {
    auto frames = pair_with_depth(folder / "color.txt", folder / "aligned_depth.txt", recording);
    if (!frames) return tl::unexpected(frames.error());
    recording.frames = std::move(*frames);
  } else {
    const auto images = read_listed_images(folder / "color.txt", 1);
    if (!images) return tl::unexpected(images.error());
    for (const auto& row : *images) recording.frames.push_back({row[0].stamp, row[0].file, {}, {}});
  }
  const auto camera = find_openloris_camera(request);
  if (!camera) return tl::unexpected(camera.error());
  take_camera(*camera, 1000, recording);
  if (fs::exists(folder / "groundtruth.txt")) {
    recording.truth = Truth{folder / "groundtruth.txt", base_to_colour(folder / "trans_matrix.yaml")};
    if (!recording.truth->T_bc) {
      recording.notes.push_back(
          "trans_matrix.yaml does not tell where the camera is on the robot (base_link to d400_color); groundtruth.txt "
          "is of the robot's base, and errors will hold the arm between the two");
    }
  }
  return recording;
}

}  // namespace covis::io
