// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/expected_view.h"

#include <algorithm>

#include "covis/core/reserve.h"
#include "covis/geometry/measurement.h"

namespace covis {

// Reserves room in advance; its memory is used only when points come.
ExpectedView::ExpectedView() { points_.reserve(1 << 14); }

ExpectedView::Cell* ExpectedView::cell(const ImageBounds& image, double u, double v) {
  const double column = (u - image.min_x) / (image.max_x - image.min_x) * kColumns;
  const double row = (v - image.min_y) / (image.max_y - image.min_y) * kRows;
  if (!(column >= 0 && column < kColumns && row >= 0 && row < kRows)) return nullptr;
  return &cells_[static_cast<size_t>(row) * kColumns + static_cast<size_t>(column)];
}

void ExpectedView::measure(const TrackedFrame& frame) {
  cells_.fill({});
  const Features& f = *frame.features;
  for (size_t i = 0; i < frame.source.size(); ++i) {
    double depth = f.depth[i];
    if (frame.on_map(i)) depth = std::max(depth, (frame.T_cw * frame.positions[i]).z());
    if (!(depth > 0)) continue;
    if (Cell* c = cell(f.grid.bounds, f.x[i], f.y[i])) {
      ++c->seen;
      c->farthest = std::max(c->farthest, depth);
    }
  }
}

double ExpectedView::look(const LocalMap& local_map, std::span<const uint8_t> in_view, const TrackedFrame& frame,
                          const Pinhole& camera) {
  constexpr int kEnough = 4;       // keypoints in a cell to say how far one sees there
  constexpr double kBeyond = 1.5;  // times that depth: a point so far away is covered
  measure(frame);
  reserve_ahead(points_, in_view.size());
  points_.assign(in_view.begin(), in_view.end());
  double matches = 0;
  for (size_t k = 0; k < points_.size(); ++k) {
    if (!points_[k]) continue;
    const Eigen::Vector3d p_c = frame.T_cw * local_map.points.position(k);
    if (p_c.z() > 0) {
      const PredictedMeasurement h = predict_measurement(p_c, camera);
      const Cell* c = cell(frame.features->grid.bounds, h.u, h.v);
      if (c && c->seen >= kEnough && p_c.z() > kBeyond * c->farthest) points_[k] = 0;
    }
    if (points_[k]) matches += local_map.match_ratio[k];
  }
  return matches;
}

}  // namespace covis
