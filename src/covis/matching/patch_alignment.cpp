// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/patch_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace covis {
namespace {

constexpr int kWindow = 8;            // pixels: side of what is compared, in the middle of a patch
constexpr int kFramed = kWindow + 2;  // with a pixel more on each side, for gradients
constexpr int kPixels = kWindow * kWindow;
constexpr float kHalf = (kWindow - 1) / 2.0f;  // from a keypoint to the outermost pixels compared
constexpr int kSide = Patch::kSide;

// A row of the window at a time: compilers make vectors of it, in whatever length, with the same sums.
using Row = std::array<float, kWindow>;
using Rows = std::array<Row, kWindow>;

float sum_of(const Row& lanes) {
  return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) + ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

float sum_of_products(const Rows& a, const Rows& b) {
  Row lanes{};
  for (size_t y = 0; y < kWindow; ++y)
    for (size_t x = 0; x < kWindow; ++x) lanes[x] += a[y][x] * b[y][x];
  return sum_of(lanes);
}

void subtract_mean(Rows& rows) {
  Row lanes{};
  for (const Row& row : rows)
    for (size_t x = 0; x < kWindow; ++x) lanes[x] += row[x];
  const float mean = sum_of(lanes) / kPixels;
  for (Row& row : rows)
    for (float& value : row) value -= mean;
}

// Bilinear; places beyond the patch have the grey level of its border.
float sample(const Patch& patch, const Eigen::Vector2f& at) {
  const float x = std::clamp(at.x(), 0.0f, kSide - 1.001f), y = std::clamp(at.y(), 0.0f, kSide - 1.001f);
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const float fx = x - static_cast<float>(left), fy = y - static_cast<float>(top);
  const uint8_t* p = patch.grey.data() + static_cast<ptrdiff_t>(top) * kSide + left;
  const float upper = static_cast<float>(p[0]) * (1 - fx) + static_cast<float>(p[1]) * fx;
  const float lower = static_cast<float>(p[kSide]) * (1 - fx) + static_cast<float>(p[kSide + 1]) * fx;
  return upper * (1 - fy) + lower * fy;
}

// The window of the reference as the view should show it, without its mean, and its gradients.
struct Template {
  Rows grey, gradient_x, gradient_y;

  Template(const PatchView& reference, const Eigen::Matrix2f& warp) {
    std::array<std::array<float, kFramed>, kFramed> framed;
    for (int y = 0; y < kFramed; ++y) {
      for (int x = 0; x < kFramed; ++x) {
        const Eigen::Vector2f from_centre(static_cast<float>(x) - kHalf - 1, static_cast<float>(y) - kHalf - 1);
        framed[static_cast<size_t>(y)][static_cast<size_t>(x)] =
            sample(reference.patch, reference.at + warp * from_centre);
      }
    }
    for (size_t y = 0; y < kWindow; ++y) {
      for (size_t x = 0; x < kWindow; ++x) {
        grey[y][x] = framed[y + 1][x + 1];
        gradient_x[y][x] = (framed[y + 1][x + 2] - framed[y + 1][x]) / 2;
        gradient_y[y][x] = (framed[y + 2][x + 1] - framed[y][x + 1]) / 2;
      }
    }
    for (Rows* rows : {&grey, &gradient_x, &gradient_y}) subtract_mean(*rows);
  }
};

// The window of a view around a place, without its mean. False: it reaches beyond the patch.
bool read_window(const std::array<float, kSide * kSide>& grey, const Eigen::Vector2f& at, Rows& window) {
  const Eigen::Vector2f corner = at.array() - kHalf;
  if (!(corner.minCoeff() >= 0 && corner.maxCoeff() < kSide - kWindow)) return false;
  const int left = static_cast<int>(corner.x()), top = static_cast<int>(corner.y());
  const float fx = corner.x() - static_cast<float>(left), fy = corner.y() - static_cast<float>(top);
  const float a = (1 - fx) * (1 - fy), b = fx * (1 - fy), c = (1 - fx) * fy, d = fx * fy;
  for (int y = 0; y < kWindow; ++y) {
    const float* upper = grey.data() + static_cast<ptrdiff_t>(top + y) * kSide + left;
    const float* lower = upper + kSide;
    Row& row = window[static_cast<size_t>(y)];
    for (size_t x = 0; x < kWindow; ++x) row[x] = a * upper[x] + b * upper[x + 1] + c * lower[x] + d * lower[x + 1];
  }
  subtract_mean(window);
  return true;
}

}  // namespace

std::optional<PatchView> PatchView::of(const Features& features, size_t feature) {
  const Patch* patch = features.patches ? features.patches->find(feature) : nullptr;
  if (!patch) return std::nullopt;
  const Eigen::Vector2f& stretch = features.patches->stretch[features.level[feature]];
  const Eigen::Vector2f image(features.image_x()[feature], features.image_y()[feature]);
  return PatchView{*patch, (image - patch->origin).cwiseQuotient(stretch), stretch};
}

std::optional<Eigen::Matrix2f> patch_warp(const Pinhole& camera, const Eigen::Vector3d& p_r, const SE3& T_vr,
                                          const Eigen::Vector2f& stretch_r, const Eigen::Vector2f& stretch_v) {
  constexpr double kGreatest = 1.5;  // change of size, and its inverse
  const Eigen::Vector3d p_v = T_vr * p_r;
  if (!(p_r.z() > 0) || !(p_v.z() > 0)) return std::nullopt;
  // A pixel to the side in the reference is a step on the plane through the point that faces the reference camera.
  const double squared = p_r.squaredNorm();
  const auto step = [&](const Eigen::Vector3d& ray) {
    const Eigen::Vector3d on_plane = p_r.z() * (ray - p_r * (p_r.dot(ray) / squared));
    const Eigen::Vector3d in_view = T_vr.R() * on_plane;
    const double iz = 1 / p_v.z();
    return Eigen::Vector2d(camera.fx * iz * (in_view.x() - p_v.x() * iz * in_view.z()),
                           camera.fy * iz * (in_view.y() - p_v.y() * iz * in_view.z()));
  };
  const Eigen::Vector2d along_x = step({1 / camera.fx, 0, 0}), along_y = step({0, 1 / camera.fy, 0});
  // In pixels of the patches, from the reference to the view; then its inverse.
  const Eigen::Vector2d to_r = stretch_r.cast<double>(), to_v = stretch_v.cast<double>();
  const double a = along_x.x() * to_r.x() / to_v.x(), b = along_y.x() * to_r.y() / to_v.x();
  const double c = along_x.y() * to_r.x() / to_v.y(), d = along_y.y() * to_r.y() / to_v.y();
  const double area = a * d - b * c;
  const double norm2 = a * a + b * b + c * c + d * d;  // sum of the squared singular values
  const double larger2 = (norm2 + std::sqrt(std::max(0.0, norm2 * norm2 - 4 * area * area))) / 2;
  const double greatest2 = kGreatest * kGreatest;
  if (!(area > 0) || !(larger2 <= greatest2) || !(area * area >= larger2 / greatest2)) return std::nullopt;
  Eigen::Matrix2d warp;
  warp << d, -b, -c, a;
  return Eigen::Matrix2f((warp / area).cast<float>());
}

std::optional<Eigen::Vector2f> align_patch(const PatchView& reference, const Eigen::Matrix2f& warp,
                                           const PatchView& view) {
  constexpr int kIterations = 8;
  constexpr float kSettled = 0.02f, kMostMove = 1, kLeastCorrelation = 0.8f;
  const Template t(reference, warp);
  const float xx = sum_of_products(t.gradient_x, t.gradient_x), xy = sum_of_products(t.gradient_x, t.gradient_y);
  const float yy = sum_of_products(t.gradient_y, t.gradient_y), contrast = sum_of_products(t.grey, t.grey);
  const float gx = sum_of_products(t.grey, t.gradient_x), gy = sum_of_products(t.grey, t.gradient_y);
  const float area = xx * yy - xy * xy;
  if (!(area > 0) || !(contrast > 0)) return std::nullopt;
  std::array<float, kSide * kSide> grey;
  std::copy(view.patch.grey.begin(), view.patch.grey.end(), grey.begin());
  Eigen::Vector2f moved = Eigen::Vector2f::Zero();
  for (int k = 0; k < kIterations; ++k) {
    Rows window;
    if (!read_window(grey, view.at + moved, window)) return std::nullopt;
    const float seen = sum_of_products(window, window);
    if (!(seen > 0)) return std::nullopt;
    const float gain = std::sqrt(contrast / seen);
    const float bx = gain * sum_of_products(window, t.gradient_x) - gx;
    const float by = gain * sum_of_products(window, t.gradient_y) - gy;
    const Eigen::Vector2f step((yy * bx - xy * by) / area, (xx * by - xy * bx) / area);
    const bool settled = step.squaredNorm() < kSettled * kSettled;
    if (settled && !(sum_of_products(window, t.grey) >= kLeastCorrelation * std::sqrt(contrast * seen)))
      return std::nullopt;
    moved -= step;
    if (!(moved.squaredNorm() <= kMostMove * kMostMove)) return std::nullopt;  // also for what is not a number
    if (settled) return moved;
  }
  return std::nullopt;
}

std::optional<AlignedPlace> moved_place(const Features& features, size_t feature, const Eigen::Vector2f& step,
                                        const Eigen::Vector2f& stretch) {
  const Eigen::Vector2f by = step.cwiseProduct(stretch);
  AlignedPlace place{by + Eigen::Vector2f(features.image_x()[feature], features.image_y()[feature]),
                     by + Eigen::Vector2f(features.x[feature], features.y[feature])};
  if (features.raw_x.empty()) return place;
  const auto straight = [&features](const Eigen::Vector2f& image) {
    std::optional<Eigen::Vector2d> at = image.cast<double>();
    if (features.lens) at = features.lens->undistort(*at);
    if (at && features.straightened_for) at = features.straightened_for->straightened(*at);
    return at;
  };
  const auto at = straight(place.image);
  if (!at) return std::nullopt;
  if (features.exposure.row_time != 0) {
    // The turn of the camera moves it as it moves the keypoint.
    const auto keypoint = straight(place.image - by);
    if (!keypoint) return std::nullopt;
    place.undistorted += (*at - *keypoint).cast<float>() - by;
  } else {
    place.undistorted = at->cast<float>();
  }
  return place;
}

std::optional<PatchQuestion> PatchQuestion::of(const Pinhole& camera, const Features& reference, size_t seen,
                                               const Eigen::Vector3d& p_r, const SE3& T_vr, const Features& view,
                                               size_t feature) {
  if (!reference.patches || !view.patches) return std::nullopt;
  const auto warp = patch_warp(camera, p_r, T_vr, reference.patches->stretch[reference.level[seen]],
                               view.patches->stretch[view.level[feature]]);
  if (!warp) return std::nullopt;
  const std::optional<PatchView> patch = PatchView::of(reference, seen);
  if (!patch) return std::nullopt;
  return PatchQuestion{*patch, *warp};
}

std::optional<AlignedPlace> PatchQuestion::answer(const Features& view, size_t feature) const {
  const std::optional<PatchView> patch = PatchView::of(view, feature);
  if (!patch) return std::nullopt;
  const std::optional<Eigen::Vector2f> step = align_patch(reference, warp, *patch);
  return step ? moved_place(view, feature, *step, patch->stretch) : std::nullopt;
}

}  // namespace covis
