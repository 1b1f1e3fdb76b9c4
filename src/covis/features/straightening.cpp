// SPDX-License-Identifier: Apache-2.0
#include "covis/features/straightening.h"

#include <utility>

#include "covis/features/unrolling.h"
#include "covis/geometry/measurement.h"

namespace covis {
namespace {

bool looked_up_for(const Features& features, const Pinhole& camera) {
  return !features.kept_depth || features.kept_depth->looked_up_by() == camera.registration;
}

bool unrolled_for(const Features& features, const Pinhole& camera) {
  return features.exposure.rate.isZero(0) || features.exposure.row_time == camera.row_time;
}

bool same_residual(const Pinhole& a, const Pinhole& b) {
  return a.residual == b.residual && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy;
}

// The keypoints are free of this camera's residual distortion.
bool has_residual_of(const Features& features, const Pinhole& camera) {
  return features.straightened_for ? same_residual(*features.straightened_for, camera) : !camera.residual.any();
}

// The right image's columns are free of this camera's error.
bool has_columns_of(const Features& features, const Pinhole& camera) {
  return field_of(features.right_columns) == camera.right_columns;
}

template <class Change>
ImageBounds changed(const ImageBounds& b, Change&& change) {
  constexpr int kSteps = 8;
  ImageBounds box{b.max_x, b.max_y, b.min_x, b.min_y};
  for (int i = 0; i <= kSteps; ++i) {
    for (int k = 0; k <= kSteps; ++k) {
      if (i % kSteps != 0 && k % kSteps != 0) continue;
      const float x = b.min_x + (b.max_x - b.min_x) * static_cast<float>(i) / kSteps;
      const float y = b.min_y + (b.max_y - b.min_y) * static_cast<float>(k) / kSteps;
      const Eigen::Vector2f at = change(Eigen::Vector2d(x, y)).template cast<float>();
      box = {std::min(box.min_x, at.x()), std::min(box.min_y, at.y()), std::max(box.max_x, at.x()),
             std::max(box.max_y, at.y())};
    }
  }
  return box;
}

// The keypoints still have the turn between their rows.
void straighten(const Pinhole& camera, Features& f) {
  f.raw_x = AlignedVector<float>(f.image_x());
  f.raw_y = AlignedVector<float>(f.image_y());
  const Pinhole before = f.straightened_for ? *f.straightened_for : Pinhole{};
  f.straightened_for = camera.residual.any() ? std::make_shared<const Pinhole>(camera) : nullptr;
  constexpr double kFarthest = 1e6;  // pixels
  const auto change = [&](const Eigen::Vector2d& at) {
    const Eigen::Vector2d straight = camera.straightened(before.bent(at)).value_or(at);
    return straight.cwiseAbs().maxCoeff() < kFarthest ? straight : at;  // also for what is not a number
  };
  for (size_t i = 0; i < f.x.size(); ++i) {
    const Eigen::Vector2f at = change({f.x[i], f.y[i]}).cast<float>();
    f.x[i] = at.x();
    f.y[i] = at.y();
    f.u_right[i] = f.depth[i] > 0 ? f.x[i] - static_cast<float>(camera.bf) / f.depth[i] : -1.0f;
  }
  const ImageBounds bounds = changed(f.grid.bounds, change);
  f.grid.build(bounds, f.x, f.y);
}

// Depths follow.
void move_columns(const Pinhole& camera, Features& f) {
  Pinhole before = camera;
  before.right_columns = field_of(f.right_columns);
  for (size_t i = 0; i < f.x.size(); ++i) {
    if (!(f.depth[i] > 0)) continue;
    const double rectified = static_cast<double>(f.u_right[i]), v = static_cast<double>(f.y[i]);
    const double measured = 2 * rectified - before.rectified_column(rectified, v);
    const auto u = static_cast<float>(camera.rectified_column(measured, v));
    const float disparity = std::max(f.x[i] - u, kLeastDisparity);
    f.u_right[i] = f.x[i] - disparity;
    f.depth[i] = static_cast<float>(camera.bf) / disparity;
  }
  f.right_columns = shared_field(camera.right_columns);
}

}  // namespace

bool straight_for(const Features& features, const Pinhole& camera) {
  return has_residual_of(features, camera) && unrolled_for(features, camera) && looked_up_for(features, camera) &&
         has_columns_of(features, camera);
}

std::shared_ptr<Features> straightened(const Features& of, const Pinhole& camera) {
  auto f = std::make_shared<Features>(of);
  const ExposureTurn before = f->exposure;
  const ExposureTurn turn{before.rate, before.rate.isZero(0) ? before.row_time : camera.row_time};
  if (!has_residual_of(*f, camera)) {
    if (before.row_time != 0) unroll(f->straightened_for ? *f->straightened_for : camera, {before.rate, 0}, *f);
    straighten(camera, *f);
  }
  if (f->exposure.row_time != turn.row_time) unroll(camera, turn, *f);
  if (!has_columns_of(*f, camera)) move_columns(camera, *f);
  if (!looked_up_for(*f, camera)) f->kept_depth->look_up(camera, *f);
  return f;
}

std::shared_ptr<Features> key_frame_features(const Features& features, std::shared_ptr<const KeptDepth> depth,
                                             const Eigen::Vector3d& turn_rate, const Pinhole& camera) {
  std::shared_ptr<Features> copy = features.for_key_frame();
  if (copy->exposure.row_time == 0) copy->exposure.rate = turn_rate;
  copy->kept_depth = std::move(depth);
  return straight_for(*copy, camera) ? copy : straightened(*copy, camera);
}

ImageBounds straightened(const ImageBounds& bounds, const Pinhole& camera) {
  return changed(bounds, [&](const Eigen::Vector2d& at) { return camera.straightened(at).value_or(at); });
}

}  // namespace covis
