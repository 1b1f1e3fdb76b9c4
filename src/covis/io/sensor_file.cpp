// SPDX-License-Identifier: Apache-2.0
#include "covis/io/sensor_file.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "covis/geometry/camera_check.h"
#include "covis/io/yaml.h"

namespace covis::io {

std::optional<Distortion> distortion_named(const std::string& name) {
  if (name == "radial-tangential" || name == "radtan" || name == "plumb_bob") return Distortion::brown_conrady;
  if (name == "equidistant") return Distortion::kannala_brandt;
  if (name == "none") return Distortion::none;
  return std::nullopt;
}

Result<std::vector<double>> read_intrinsics(const std::filesystem::path& file, const YAML::Node& camera) {
  const std::string model = yaml_text(camera, "camera_model", "pinhole");
  if (model != "pinhole") {
    return fail(yaml_place(file, camera["camera_model"]) + ": camera_model '" + model +
                "' can't be used; it must be pinhole");
  }
  auto values = yaml_numbers(file, camera, "intrinsics", 4);
  if (values && values->size() > 4) {
    return fail(yaml_place(file, camera["intrinsics"]) + ": intrinsics has " + std::to_string(values->size()) +
                " numbers; it must have the 4 of a pinhole camera");
  }
  return values;
}

Result<std::array<double, 5>> read_coefficients(const std::filesystem::path& file, const YAML::Node& camera,
                                                const char* key, Distortion lens) {
  const auto values = yaml_numbers(file, camera, key, 4);
  if (!values) return tl::unexpected(values.error());
  const auto too_many = [&](const char* right) {
    return fail(yaml_place(file, camera[key]) + ": " + key + " has " + std::to_string(values->size()) +
                " numbers; it must have " + right);
  };
  if (lens == Distortion::kannala_brandt && values->size() > 4) return too_many("4: k1 k2 k3 k4");
  constexpr ptrdiff_t kMost = 5;
  std::array<double, 5> coefficients{};
  const auto end = values->begin() + std::min(std::ssize(*values), kMost);
  if (std::any_of(end, values->end(), [](double value) { return value != 0; }))
    return too_many("4 or 5, k1 k2 p1 p2 [k3], and zeros behind them");
  std::copy(values->begin(), end, coefficients.begin());
  return coefficients;
}

namespace {

Result<SE3> pose_of_sensor(const std::filesystem::path& file, const YAML::Node& root) {
  if (!root.IsMap() || !root["T_BS"])
    return fail(file.string() + ": 'T_BS' is missing, a map with a list 'data' of 16 numbers is expected");
  const auto t = yaml_numbers(file, root, "T_BS", 16);
  if (!t) return tl::unexpected(t.error());
  Eigen::Matrix3d R;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) R(r, c) = (*t)[static_cast<size_t>(r * 4 + c)];
  }
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-3 || R.determinant() < 0) {
    return fail(file.string() + ": T_BS does not hold a rotation");
  }
  return SE3(R, Eigen::Vector3d((*t)[3], (*t)[7], (*t)[11])).normalized();
}

Result<Camera> camera_of_sensor(const std::filesystem::path& file, const YAML::Node& root) {
  const auto size = yaml_numbers(file, root, "resolution", 2);
  if (!size) return tl::unexpected(size.error());
  const auto k = read_intrinsics(file, root);
  if (!k) return tl::unexpected(k.error());
  for (const double side : *size) {
    if (side >= CameraBounds::kLeastSide && side <= CameraBounds::kLargestSide && side == std::floor(side)) continue;
    std::ostringstream wrong;
    wrong << yaml_place(file, root["resolution"]) << ": resolution: " << (*size)[0] << ", " << (*size)[1]
          << " is not right; it must be width and height, whole numbers from " << CameraBounds::kLeastSide << " to "
          << CameraBounds::kLargestSide;
    return fail(wrong.str());
  }
  Camera camera;
  camera.width = static_cast<int>((*size)[0]);
  camera.height = static_cast<int>((*size)[1]);
  camera.pinhole = {(*k)[0], (*k)[1], (*k)[2], (*k)[3], 0};
  const std::string model = yaml_text(root, "distortion_model", "none");
  const auto distortion = distortion_named(model);
  if (!distortion) {
    return fail(file.string() + ": distortion_model '" + model +
                "' is unknown; it must be radial-tangential, equidistant or none");
  }
  camera.distortion = *distortion;
  if (camera.distortion != Distortion::none) {
    const auto coefficients = read_coefficients(file, root, "distortion_coefficients", camera.distortion);
    if (!coefficients) return tl::unexpected(coefficients.error());
    camera.coefficients = *coefficients;
  }
  if (const auto problem = problem_of(camera)) return fail(file.string() + ": " + *problem);
  return camera;
}

}  // namespace

Result<SE3> read_sensor_pose(const std::filesystem::path& file) {
  const auto root = load_yaml(file);
  if (!root) return tl::unexpected(root.error());
  return pose_of_sensor(file, *root);
}

Result<SensorFile> read_sensor_file(const std::filesystem::path& file) {
  const auto root = load_yaml(file);
  if (!root) return tl::unexpected(root.error());
  const auto pose = pose_of_sensor(file, *root);
  if (!pose) return tl::unexpected(pose.error());
  const auto camera = camera_of_sensor(file, *root);
  if (!camera) return tl::unexpected(camera.error());
  SensorFile sensor{*camera, *pose};
  if ((*root)["rate_hz"]) {
    const auto rate = yaml_number(file, *root, "rate_hz");
    if (!rate) return tl::unexpected(rate.error());
    sensor.rate = std::max(0.0, *rate);
  }
  return sensor;
}

std::string sensor_file_text(const SensorFile& sensor) {
  const Camera& c = sensor.camera;
  std::ostringstream text;
  text.precision(17);
  text << "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [";
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) text << sensor.T_bs.R()(r, k) << ", ";
    text << sensor.T_bs.t()(r) << ", ";
  }
  text << "0, 0, 0, 1]\n";
  if (sensor.rate > 0) text << "rate_hz: " << sensor.rate << "\n";
  text << "resolution: [" << c.width << ", " << c.height << "]\ncamera_model: pinhole\nintrinsics: [" << c.pinhole.fx
       << ", " << c.pinhole.fy << ", " << c.pinhole.cx << ", " << c.pinhole.cy << "]\ndistortion_model: ";
  if (c.distortion == Distortion::none) {
    text << "none\n";
    return text.str();
  }
  const bool fisheye = c.distortion == Distortion::kannala_brandt;
  text << (fisheye ? "equidistant" : "radial-tangential") << "\ndistortion_coefficients: [";
  for (size_t i = 0; i < (fisheye ? 4 : 5); ++i) text << (i ? ", " : "") << c.coefficients[i];
  text << "]\n";
  return text.str();
}

}  // namespace covis::io
