// SPDX-License-Identifier: Apache-2.0
// The depth image of a key frame, kept at half size while it is not sure where depth images show what images show
// (DepthRegistration), so that depths can be looked up again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "covis/core/image.h"
#include "covis/geometry/camera.h"

namespace covis {

struct Features;

class KeptDepth {
 public:
  // depth: metres, as it came, looked up as if it were registered; 0 or non-finite: no measurement.
  explicit KeptDepth(ImageView<const float> depth);

  // The registration by which its key frame's features have their depths.
  const DepthRegistration& looked_up_by() const { return looked_up_by_; }
  int width() const { return width_; }  // pixels, as it came
  // 1 / metres near a pixel; 0: no measurement, or beyond the image.
  float inverse_near(const Eigen::Vector2f& pixel) const {
    const Eigen::Vector2f at = (pixel.array() / 2 + 0.5f).matrix();
    if (!(at.x() >= 0 && at.x() < static_cast<float>(columns_) && at.y() >= 0 && at.y() < static_cast<float>(rows_)))
      return 0;
    const auto column = static_cast<size_t>(at.x()), row = static_cast<size_t>(at.y());
    return static_cast<float>((*inverse_)[row * static_cast<size_t>(columns_) + column]) * kUnit;
  }
  // Looks up the depths of these features anew, by the registration of this camera (not none: depth that is registered
  // to an image has its lens too), whose pixels theirs are; they keep
  // this depth image from then on.
  void look_up(const Pinhole& camera, Features& features) const;
  size_t bytes() const { return inverse_->size() * sizeof(uint16_t); }

 private:
  static constexpr float kUnit = 1 / 6553.5f;  // 1 / metres: what is nearer than 0.1 m has no measurement

  int width_ = 0, columns_ = 0, rows_ = 0;
  std::shared_ptr<const std::vector<uint16_t>> inverse_;  // every second pixel of every second row; 0: no measurement
  DepthRegistration looked_up_by_;
};

}  // namespace covis
