// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/patch_alignment.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "covis/features/pyramid.h"
#include "covis/io/images.h"

namespace covis::exchange {
namespace {

constexpr int kRadius = 5;  // of a patch, in pixels of the level on which its keypoint was found
constexpr int kSide = 2 * kRadius + 1, kRim = kSide + 2;  // with a rim of a pixel, for the gradients
constexpr int kSteps = 15;
constexpr double kConverged = 0.02;     // pixels of the patch: no further steps
constexpr double kUnsettled = 0.1;      // pixels of the patch: a last step of that length did not converge
constexpr double kFarthest = 2.5;       // standard deviations of a keypoint, to where it is found again
constexpr float kAlike = 0.85f;         // least correlation of two patches
constexpr float kLeastTexture = 0.02f;  // ratio of the gradients' squares across and along: less is a straight edge

using Patch = Eigen::Array<float, kSide * kSide, 1>;
using RimmedPatch = std::array<float, kRim * kRim>;

// An image at its own size and smaller ones.
class Pyramid {
 public:
  static constexpr double kFactor = 1.2;
  static constexpr int kLevels = 12;

  void build(ImageU8 image) {
    levels_[0] = std::move(image);
    for (int k = 1; k < kLevels; ++k) {
      const ImageU8& from = levels_[static_cast<size_t>(k - 1)];
      const double shrink = std::pow(kFactor, k);
      const auto side = [&](int whole) { return std::max(kRim, static_cast<int>(std::lround(whole / shrink))); };
      ImageU8& to = levels_[static_cast<size_t>(k)];
      to.resize(std::min(from.width(), side(levels_[0].width())), std::min(from.height(), side(levels_[0].height())));
      resizers_[static_cast<size_t>(k)].resize(from.view(), to.view());
    }
  }
  // Fills `patch` with the values at centre + grid * (column, row), both from -(side - 1) / 2 on, of the level whose
  // pixels are as wide as the grid's. False: the image does not have them all.
  bool sample(const Eigen::Vector2d& centre, const Eigen::Matrix2d& grid, int side, float* patch) const {
    const double width = std::sqrt(std::abs(grid.determinant()));
    const double level = std::round(std::log(std::max(1.0, width)) / std::log(kFactor));
    const ImageU8& image = levels_[static_cast<size_t>(std::clamp(level, 0.0, kLevels - 1.0))];
    const Eigen::Array2d shrink(static_cast<double>(image.width()) / levels_[0].width(),
                                static_cast<double>(image.height()) / levels_[0].height());
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) {
        const Eigen::Vector2d from_centre(column - side / 2, row - side / 2);
        const Eigen::Array2d at = ((centre + grid * from_centre).array() + 0.5) * shrink - 0.5;
        if (!(at.x() >= 0 && at.y() >= 0 && at.x() < image.width() - 1 && at.y() < image.height() - 1)) return false;
        const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
        const auto fx = static_cast<float>(at.x() - x), fy = static_cast<float>(at.y() - y);
        const uint8_t *upper = image.row(y) + x, *lower = image.row(y + 1) + x;
        const float a = static_cast<float>(upper[0]) + fx * static_cast<float>(upper[1] - upper[0]);
        const float b = static_cast<float>(lower[0]) + fx * static_cast<float>(lower[1] - lower[0]);
        *patch++ = a + fy * (b - a);
      }
    }
    return true;
  }

 private:
  std::array<ImageU8, kLevels> levels_;
  std::array<BilinearResizer, kLevels> resizers_;
};

// Leaves out mean and contrast. False: there is none.
bool normalise(Patch& patch, float& contrast) {
  patch -= patch.mean();
  contrast = patch.matrix().norm();
  patch /= contrast;
  return contrast > kSide;  // a grey level by each pixel
}

// The patch that is looked for in an image.
struct Template {
  explicit Template(const RimmedPatch& rimmed) {
    const auto at = [&](int column, int row) { return rimmed[static_cast<size_t>((row + 1) * kRim + column + 1)]; };
    for (int row = 0, i = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column, ++i) {
        value(i) = at(column, row);
        slope(i, 0) = (at(column + 1, row) - at(column - 1, row)) / 2;
        slope(i, 1) = (at(column, row + 1) - at(column, row - 1)) / 2;
      }
    }
    float contrast = 0;
    if (!normalise(value, contrast)) return;
    slope.rowwise() -= slope.colwise().mean();
    slope /= contrast;
    const Eigen::Matrix2f squares = slope.transpose() * slope;
    const float half_trace = squares.trace() / 2;
    const float spread = std::sqrt(std::max(0.0f, half_trace * half_trace - squares.determinant()));
    usable = half_trace - spread > kLeastTexture * (half_trace + spread);
    inverse = squares.inverse();
  }
  Patch value;
  Eigen::Matrix<float, kSide * kSide, 2> slope;
  Eigen::Matrix2f inverse;
  bool usable = false;
};

// The place near `begin` at which the image shows the template on a grid; nothing where it does not.
std::optional<Eigen::Vector2d> find(const Template& wanted, const Pyramid& image, const Eigen::Matrix2d& grid,
                                    const Eigen::Vector2d& begin) {
  Eigen::Vector2d at = begin, step(1, 1);
  Patch seen;
  float contrast = 0;
  for (int k = 0; k < kSteps && step.norm() > kConverged; ++k) {
    if (!image.sample(at, grid, kSide, seen.data()) || !normalise(seen, contrast)) return {};
    const Eigen::Vector2f error = wanted.slope.transpose() * (seen - wanted.value).matrix();
    step = (wanted.inverse * error).cast<double>();
    if (step.norm() > 1) step.normalize();
    at -= grid * step;
  }
  const double width = std::max(1.0, std::sqrt(std::abs(grid.determinant())));
  if (!(step.norm() < kUnsettled) || !((at - begin).norm() <= kFarthest * width)) return {};
  const float alike = (seen * wanted.value).sum();
  return alike >= kAlike ? std::optional(at) : std::nullopt;
}

// How pixels around a point move from one view to another, as they show the plane through it that faces its observers.
std::optional<Eigen::Matrix2d> warp(const Scene& scene, const ScenePoint& point, const SceneView& from,
                                    const SceneView& to) {
  const Pinhole &camera = scene.cameras[from.camera].pinhole, &other = scene.cameras[to.camera].pinhole;
  const Eigen::Vector3d p = from.T_cw * point.position, normal = from.T_cw.R() * point.normal;
  const SE3 T_to_from = to.T_cw * from.T_cw.inverse();
  if (!(p.z() > kMinDepth) || !((T_to_from * p).z() > kMinDepth)) return {};
  const Eigen::Vector2d middle = camera.project(p);
  const auto moved = [&](double u, double v) {
    const Eigen::Vector3d ray = camera.unproject(middle.x() + u, middle.y() + v);
    return other.project(T_to_from * (ray * (normal.dot(p) / normal.dot(ray))));
  };
  Eigen::Matrix2d A;
  A << (moved(1, 0) - moved(-1, 0)) / 2, (moved(0, 1) - moved(0, -1)) / 2;
  return A.allFinite() ? std::optional(A) : std::nullopt;
}

// Calls visit(index of the view, its image) for each view that has one.
template <class Visit>
Result<void> each_image(const Scene& scene, const std::filesystem::path& folder, Visit&& visit) {
  io::ImageReader reader;
  Pyramid pyramid;
  for (uint32_t v = 0; v < scene.views.size(); ++v) {
    const SceneView& view = scene.views[v];
    if (view.image.empty()) continue;
    ImageU8 image;
    if (auto read = reader.grey(folder / view.image, image); !read) return read;
    const Camera& camera = scene.cameras[view.camera].given;
    if (image.width() != camera.width || image.height() != camera.height) {
      return fail((folder / view.image).string() + ": the image is " + std::to_string(image.width()) + "x" +
                  std::to_string(image.height()) + ", its camera's are " + std::to_string(camera.width) + "x" +
                  std::to_string(camera.height));
    }
    pyramid.build(std::move(image));
    visit(v, pyramid);
  }
  return {};
}

// For each point the keypoint of the finest level in a view with an image; nothing where there is none.
std::vector<std::optional<ScenePoint::Sight>> finest_sights(const Scene& scene) {
  std::vector<std::optional<ScenePoint::Sight>> finest(scene.points.size());
  for (size_t i = 0; i < finest.size(); ++i) {
    double least = 0;
    for (const ScenePoint::Sight& sight : scene.points[i].seen) {
      const SceneView& view = scene.views[sight.view];
      const double scale = view.keypoints[sight.keypoint].scale;
      if (view.image.empty() || (finest[i] && scale >= least)) continue;
      finest[i] = sight;
      least = scale;
    }
  }
  return finest;
}

}  // namespace

Result<size_t> align_keypoints(Scene& scene, const std::filesystem::path& folder) {
  find_sights(scene);
  const auto finest = finest_sights(scene);
  const auto is_finest = [&](uint32_t view, uint32_t keypoint, uint32_t point) {
    return finest[point] && finest[point]->view == view && finest[point]->keypoint == keypoint;
  };
  // All patches first: a point's finest image may be the last one.
  std::vector<std::optional<RimmedPatch>> patches(scene.points.size());
  auto read = each_image(scene, folder, [&](uint32_t v, const Pyramid& image) {
    const auto& keypoints = scene.views[v].keypoints;
    for (uint32_t k = 0; k < keypoints.size(); ++k) {
      const SceneView::Keypoint& keypoint = keypoints[k];
      if (!is_finest(v, k, keypoint.point)) continue;
      const Eigen::Matrix2d grid = keypoint.scale * Eigen::Matrix2d::Identity();
      RimmedPatch patch;
      if (image.sample(keypoint.in_image(), grid, kRim, patch.data())) patches[keypoint.point] = patch;
    }
  });
  if (!read) return tl::unexpected(read.error());

  std::vector<uint8_t> found(scene.points.size());
  read = each_image(scene, folder, [&](uint32_t v, const Pyramid& image) {
    auto& keypoints = scene.views[v].keypoints;
    for (uint32_t k = 0; k < keypoints.size(); ++k) {
      SceneView::Keypoint& keypoint = keypoints[k];
      const ScenePoint& point = scene.points[keypoint.point];
      if (!patches[keypoint.point] || is_finest(v, k, keypoint.point)) continue;
      const SceneView& from = scene.views[finest[keypoint.point]->view];
      const auto A = warp(scene, point, from, scene.views[v]);
      const Template wanted(*patches[keypoint.point]);
      if (!A || !wanted.usable) continue;
      const double scale = from.keypoints[finest[keypoint.point]->keypoint].scale;
      const auto at = find(wanted, image, *A * scale, keypoint.in_image());
      if (!at) continue;
      keypoint.u = at->x() - keypoint.rolled.x();
      keypoint.v = at->y() - keypoint.rolled.y();
      keypoint.aligned = true;
      found[keypoint.point] = 1;
    }
  });
  if (!read) return tl::unexpected(read.error());

  for (size_t i = 0; i < finest.size(); ++i) {
    if (found[i]) scene.views[finest[i]->view].keypoints[finest[i]->keypoint].aligned = true;
  }
  size_t left_out = 0;
  for (SceneView& view : scene.views)
    left_out += std::erase_if(view.keypoints, [&](const auto& k) { return found[k.point] && !k.aligned; });
  find_sights(scene);
  return left_out;
}

}  // namespace covis::exchange
