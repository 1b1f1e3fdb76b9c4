// SPDX-License-Identifier: Apache-2.0
#include "covis/features/kept_depth.h"

#include <utility>

#include "covis/features/depth_lookup.h"
#include "covis/features/features.h"

namespace covis {

KeptDepth::KeptDepth(ImageView<const float> depth)
    : width_(depth.width), columns_((depth.width + 1) / 2), rows_((depth.height + 1) / 2) {
  constexpr float kMost = 65535;
  auto made = std::make_shared<std::vector<uint16_t>>();
  made->reserve(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));
  for (int y = 0; y < depth.height; y += 2) {
    const float* row = depth.row(y);
    for (int x = 0; x < depth.width; x += 2) {
      const float inverse = 1 / (kUnit * row[x]);
      made->push_back(inverse >= 0.5f && inverse <= kMost ? static_cast<uint16_t>(inverse + 0.5f) : uint16_t{0});
    }
  }
  inverse_ = std::move(made);
}

void KeptDepth::look_up(const Pinhole& camera, Features& features) const {
  ImageF metres(columns_, rows_);
  for (int y = 0; y < rows_; ++y) {
    const uint16_t* row = inverse_->data() + static_cast<size_t>(y) * static_cast<size_t>(columns_);
    for (int x = 0; x < columns_; ++x) metres(x, y) = row[x] ? 1 / (static_cast<float>(row[x]) * kUnit) : 0.0f;
  }
  DepthRegistration half = camera.registration;
  for (double* pixels : {&half.shift_x, &half.shift_y, &half.parallax_x, &half.parallax_y}) *pixels /= 2;
  const Eigen::Vector2d centre(camera.cx / 2, camera.cy / 2);
  for (size_t i = 0; i < features.x.size(); ++i) {
    const float scale = features.pyramid->scale[features.level[i]] / 2;
    const Eigen::Vector2f at = features.pinhole_pixel(i).cast<float>() / 2;
    const float z = depth_at(metres.view(), half, centre, at.x(), at.y(), scale);
    features.depth[i] = z;
    features.u_right[i] = z > 0 ? features.x[i] - static_cast<float>(camera.bf) / z : -1.0f;
  }
  auto kept = std::make_shared<KeptDepth>(*this);
  kept->looked_up_by_ = camera.registration;
  features.kept_depth = std::move(kept);
}

}  // namespace covis
