// SPDX-License-Identifier: Apache-2.0
#include "covis/io/camera_import.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "covis/features/rectification.h"
#include "covis/geometry/camera_check.h"
#include "covis/io/open3d_camera.h"
#include "covis/io/ros_camera.h"
#include "covis/io/yaml.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

// True when both images are those of equal pinhole cameras side by side, so that nothing needs to be rectified.
bool is_rectified_pair(const Camera& left, const Camera& right, const SE3& T_rl) {
  constexpr double kPixels = 1e-3, kRadians = 1e-6, kShare = 1e-4;
  const auto lensless = [](const Camera& c) {
    return c.distortion == Distortion::none ||
           (c.distortion == Distortion::brown_conrady && c.coefficients == std::array<double, 5>{});
  };
  const Pinhole &a = left.pinhole, &b = right.pinhole;
  const double apart =
      std::max({std::abs(a.fx - b.fx), std::abs(a.fy - b.fy), std::abs(a.cx - b.cx), std::abs(a.cy - b.cy)});
  return lensless(left) && lensless(right) && left.width == right.width && left.height == right.height &&
         apart < kPixels && T_rl.R().isIdentity(kRadians) && T_rl.t().x() < 0 &&
         T_rl.t().tail<2>().norm() < -kShare * T_rl.t().x();
}

// file: the one that tells where the right camera is, and name: the right camera's, for messages. rate: Hz, or 0.
Result<void> add_right_camera(const fs::path& file, const Camera& right, const SE3& T_rl, const std::string& name,
                              double rate, ImportedCamera& imported) {
  const Camera left = imported.file.camera;
  if (is_rectified_pair(left, right, T_rl)) {
    imported.file.baseline = -T_rl.t().x();
    imported.file.camera.pinhole.bf = left.pinhole.fx * imported.file.baseline;
    imported.file.camera.distortion = Distortion::none;
    return check_camera_bounds(file, imported.file.camera);
  }
  if (const auto made = StereoRectification::create(left, right, T_rl); !made) {
    imported.notes.push_back(name + " is left out, for the pair can't be rectified: " + made.error().message);
    return {};
  }
  imported.pair = SensorPair{{left, SE3(), rate}, {right, T_rl.inverse(), rate}};
  return {};
}

// Reads one camera of a chain; errors name it.
Result<Camera> read_kalibr_camera(const fs::path& file, const YAML::Node& node, const std::string& name) {
  const auto wrong = [&](const std::string& key, const std::string& value, const std::string& right) {
    return fail(file.string() + ": " + name + ": " + key + " '" + value + "' can't be used; it must be " + right);
  };
  const auto of_camera = [&](const Error& error) { return tl::unexpected(Error{error.message + " (" + name + ")"}); };
  const std::string model = yaml_text(node, "camera_model", "");
  if (model != "pinhole") return wrong("camera_model", model, "pinhole");
  const std::string lens = yaml_text(node, "distortion_model", "none");
  const auto distortion = distortion_named(lens);
  if (!distortion) return wrong("distortion_model", lens, "radtan, equidistant or none");
  const auto size = yaml_numbers(file, node, "resolution", 2);
  if (!size) return of_camera(size.error());
  const auto k = read_intrinsics(file, node);
  if (!k) return of_camera(k.error());
  Camera camera;
  if (!(std::abs((*size)[0]) < 1e6 && std::abs((*size)[1]) < 1e6))
    return of_camera({file.string() + ": resolution must be width and height, in pixels"});
  camera.width = static_cast<int>((*size)[0]);
  camera.height = static_cast<int>((*size)[1]);
  camera.pinhole = {(*k)[0], (*k)[1], (*k)[2], (*k)[3], 0};
  camera.distortion = *distortion;
  if (camera.distortion != Distortion::none) {
    const auto coefficients = read_coefficients(file, node, "distortion_coeffs", camera.distortion);
    if (!coefficients) return of_camera(coefficients.error());
    camera.coefficients = *coefficients;
  }
  if (auto checked = check_camera_bounds(file, camera); !checked) return of_camera(checked.error());
  return camera;
}

Result<ImportedCamera> import_kalibr(const fs::path& file, const YAML::Node& root) {
  ImportedCamera imported{.format = "Kalibr camera chain", .file = {}, .pair = {}, .notes = {}};
  const auto left = read_kalibr_camera(file, root["cam0"], "cam0");
  if (!left) return tl::unexpected(left.error());
  imported.file.camera = *left;
  if (root["cam2"]) imported.notes.push_back("cameras from cam2 on are left out");
  if (!root["cam1"]) return imported;
  const auto right = read_kalibr_camera(file, root["cam1"], "cam1");
  if (!right) return tl::unexpected(right.error());
  const auto t = yaml_numbers(file, root["cam1"], "T_cn_cnm1", 16);
  if (!t) return tl::unexpected(Error{t.error().message + " (cam1)"});
  Eigen::Matrix4d T_rl;
  for (int i = 0; i < 16; ++i) T_rl(i / 4, i % 4) = (*t)[static_cast<size_t>(i)];
  const Eigen::Matrix3d R = T_rl.topLeftCorner<3, 3>();
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-3 || R.determinant() < 0)
    return fail(file.string() + ": T_cn_cnm1 does not hold a rotation (cam1)");
  if (auto added =
          add_right_camera(file, *right, SE3(R, T_rl.topRightCorner<3, 1>()).normalized(), "cam1", 0, imported);
      !added)
    return tl::unexpected(added.error());
  return imported;
}

// Kimera names the files of a pair; EuRoC's own are read with their sequence.
Result<ImportedCamera> import_sensor_file(const fs::path& file) {
  ImportedCamera imported{.format = "EuRoC or Kimera sensor file", .file = {}, .pair = {}, .notes = {}};
  const auto left = read_sensor_file(file);
  if (!left) return tl::unexpected(left.error());
  if (auto checked = check_camera_bounds(file, left->camera); !checked) return tl::unexpected(checked.error());
  imported.file.camera = left->camera;
  imported.file.fps = left->rate >= 0.01 && left->rate <= 10000 ? left->rate : 0;
  const fs::path right_file = file.parent_path() / "RightCameraParams.yaml";
  if (file.filename() != "LeftCameraParams.yaml" || !fs::exists(right_file)) return imported;
  const auto right = read_sensor_file(right_file);
  if (!right) return tl::unexpected(right.error());
  if (auto checked = check_camera_bounds(right_file, right->camera); !checked) return tl::unexpected(checked.error());
  if (auto added = add_right_camera(right_file, right->camera, right->T_bs.inverse() * left->T_bs,
                                    right_file.filename().string(), left->rate, imported);
      !added)
    return tl::unexpected(added.error());
  return imported;
}

// As camera_calibration writes it (image_width, camera_matrix …), or as a message is printed (width, K or k …).
Result<ImportedCamera> import_ros(const fs::path& file, const YAML::Node& root) {
  ImportedCamera imported{.format = "ROS camera_info", .file = {}, .pair = {}, .notes = {}};
  const bool calibration = root["camera_matrix"].IsDefined(), upper = root["K"].IsDefined();
  const auto name = [&](const char* of_calibration, const char* of_ros1, const char* of_ros2) {
    return calibration ? of_calibration : upper ? of_ros1 : of_ros2;
  };
  RosCameraInfo info;
  for (const auto& [key, side] : {std::pair(calibration ? "image_width" : "width", &info.width),
                                  {calibration ? "image_height" : "height", &info.height}}) {
    const auto value = yaml_number(file, root, key);
    if (!value) return tl::unexpected(value.error());
    if (!(*value >= 1 && *value <= 20000))
      return fail(file.string() + ": " + key + " must be that of the images, in pixels");
    *side = static_cast<uint32_t>(*value);
  }
  const auto k = yaml_numbers(file, root, name("camera_matrix", "K", "k"), 9);
  if (!k) return tl::unexpected(k.error());
  std::copy_n(k->begin(), 9, info.K.begin());
  const auto d = yaml_numbers(file, root, name("distortion_coefficients", "D", "d"), 0);
  if (!d) return tl::unexpected(d.error());
  info.D = *d;
  // OpenCV writes no distortion_model: its sample for calibration says by a number whether the lens is a fisheye.
  const YAML::Node fisheye = root["fisheye_model"];
  const bool is_fisheye = fisheye && fisheye.IsScalar() && fisheye.Scalar() != "0";
  info.model = yaml_text(root, "distortion_model", is_fisheye ? "equidistant" : "plumb_bob");
  const auto camera = raw_camera(info);
  if (!camera) return fail(file.string() + ": " + camera.error().message);
  if (auto checked = check_camera_bounds(file, *camera); !checked) return tl::unexpected(checked.error());
  imported.file.camera = *camera;
  if (camera->distortion != Distortion::none && root[name("projection_matrix", "P", "p")])
    imported.notes.push_back(
        "this is the camera of the images as they were taken; that of rectified images is left out");
  return imported;
}

Result<ImportedCamera> import_open3d(const fs::path& file) {
  const auto camera = read_open3d_camera(file);
  if (!camera) return tl::unexpected(camera.error());
  if (auto checked = check_camera_bounds(file, *camera); !checked) return tl::unexpected(checked.error());
  ImportedCamera imported{.format = "Open3D camera", .file = {}, .pair = {}, .notes = {}};
  imported.file.camera = *camera;
  return imported;
}

}  // namespace

Result<void> check_camera_bounds(const fs::path& file, const Camera& camera) {
  if (const auto problem = problem_of(camera)) return fail(file.string() + ": " + *problem);
  return {};
}

Result<std::optional<ImportedCamera>> import_camera_yaml(const fs::path& file) {
  const auto loaded = load_yaml(file);
  if (!loaded) {
    const std::string ending = file.extension().string();
    if (ending != ".yaml" && ending != ".yml" && ending != ".json") return std::nullopt;
    return tl::unexpected(loaded.error());
  }
  const YAML::Node& root = *loaded;
  if (!root.IsMap()) return std::nullopt;
  if (root["cam0"]) return import_kalibr(file, root);
  if (root["intrinsic_matrix"]) return import_open3d(file);
  if (root["camera_matrix"] || root["K"] || root["k"]) return import_ros(file, root);
  if (root["T_BS"]) return import_sensor_file(file);
  if (root["fx"] && root["cx"])
    return fail(file.string() + ": it is a camera file of Covis already; give it with --camera");
  return std::nullopt;
}

}  // namespace covis::io
