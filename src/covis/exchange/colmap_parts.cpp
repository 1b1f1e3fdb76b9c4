// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/colmap_parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "covis/exchange/scene.h"

namespace covis::exchange {
namespace {

struct Figures {
  size_t count;    // after the image size
  bool one_focal;  // f, cx, cy instead of fx, fy, cx, cy
  Distortion lens;
};
const std::map<std::string, Figures> kModels{{"SIMPLE_PINHOLE", {3, true, Distortion::none}},
                                             {"PINHOLE", {4, false, Distortion::none}},
                                             {"SIMPLE_RADIAL", {4, true, Distortion::brown_conrady}},
                                             {"RADIAL", {5, true, Distortion::brown_conrady}},
                                             {"OPENCV", {8, false, Distortion::brown_conrady}},
                                             {"OPENCV_FISHEYE", {8, false, Distortion::kannala_brandt}}};

constexpr int kMinSide = 64, kMaxSide = 32768;  // pixels

}  // namespace

std::optional<size_t> colmap_figures(const std::string& model) {
  const auto known = kModels.find(model);
  return known == kModels.end() ? std::nullopt : std::optional(known->second.count);
}

Error unknown_colmap_model(const std::string& model) {
  return {"camera model '" + model +
          "' is none of SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE"};
}

Result<Camera> colmap_camera(const std::string& model, int64_t width, int64_t height, std::span<const double> figures) {
  const auto& [count, one_focal, lens] = kModels.at(model);
  const size_t first = one_focal ? 1 : 2;  // index of cx, behind which are cy and the lens
  Camera camera;
  camera.pinhole = {figures[0], figures[first - 1], figures[first] - kPixelCentre, figures[first + 1] - kPixelCentre,
                    0};
  camera.distortion = lens;
  for (size_t i = first + 2; i < count; ++i) camera.coefficients[i - first - 2] = figures[i];
  const Pinhole& p = camera.pinhole;
  const bool bounded = std::all_of(figures.begin(), figures.end(), [](double v) { return std::abs(v) < 1e6; });
  const bool sized = std::min(width, height) >= kMinSide && std::max(width, height) <= kMaxSide;
  if (!bounded || !sized || !(p.fx >= 1 && p.fy >= 1) ||
      !(p.cx > 0 && p.cx < static_cast<double>(width) && p.cy > 0 && p.cy < static_cast<double>(height)))
    return fail("a " + model +
                " of at least 64 x 64 and at most 32768 x 32768 pixels with positive focal lengths of a pixel or more "
                "and its principal point in the image is wanted");
  camera.width = static_cast<int>(width);
  camera.height = static_cast<int>(height);
  return camera;
}

Result<ColmapModel::Image> colmap_image(const std::string& name, const Eigen::Vector4d& q, const Eigen::Vector3d& t) {
  const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
  if (name.empty() || !t.allFinite() || !(t.cwiseAbs().maxCoeff() < 1e9) || !(std::abs(turn.norm() - 1) < 1e-3))
    return fail("an image's id, unit quaternion, translation, camera and name are wanted");
  const std::filesystem::path path(name);
  if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end())
    return fail("the image " + name + " lies outside the folder of images");
  return ColmapModel::Image{name, SE3(turn.normalized().toRotationMatrix(), t), {}};
}

Result<ColmapModel> colmap_model(const Camera& camera, std::map<int64_t, ColmapModel::Image> by_id,
                                 const std::filesystem::path& file) {
  ColmapModel model{.camera = camera, .images = {}};
  for (auto& [id, image] : by_id) {
    std::sort(image.points.begin(), image.points.end());
    model.images.push_back(std::move(image));
  }
  if (model.images.size() < 2) return fail(file.string() + ": there are less than two images");
  return model;
}

}  // namespace covis::exchange
