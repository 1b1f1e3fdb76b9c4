// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/tracked_frame.h"

#include <algorithm>
#include <utility>

#include "covis/core/reserve.h"
#include "covis/features/straightening.h"

namespace covis {

KeyFrameRequest TrackedFrame::request() const {
  KeyFrameRequest request;
  request.frame = index;
  request.stamp = stamp;
  request.features = features;
  request.points.resize(points.size());
  return request;
}

void TrackedFrame::start(FeaturesPtr f, int64_t frame, Timestamp t) {
  features = std::move(f);
  index = frame;
  stamp = t;
  const auto n = static_cast<size_t>(features->size());
  reserve(n);
  points.assign(n, {});
  positions.resize(n);
  source.assign(n, PointSource::none);
  refused.clear();
  was_refused.assign(n, 0);
  moved.assign(n, kNever);
}

void TrackedFrame::keep(const TrackedFrame& other) {
  reserve(other.source.size());
  *this = other;
  features.reset();
}

void TrackedFrame::straighten_for(const Pinhole& camera) {
  if (features && !straight_for(*features, camera)) features = straightened(*features, camera);
}

void TrackedFrame::reserve(size_t n) {
  reserve_ahead(points, n);
  reserve_ahead(positions, n);
  reserve_ahead(source, n);
  reserve_ahead(refused, n);
  reserve_ahead(was_refused, n);
  reserve_ahead(moved, n);
}

void TrackedFrame::clear_matches() {
  std::fill(points.begin(), points.end(), MapPointId{});
  std::fill(source.begin(), source.end(), PointSource::none);
  refused.clear();
  std::fill(was_refused.begin(), was_refused.end(), uint8_t{0});
  std::fill(moved.begin(), moved.end(), kNever);
}

void TrackedFrame::set_match(size_t feature, MapPointId point, const Eigen::Vector3d& position_w, PointSource from) {
  points[feature] = point;
  positions[feature] = position_w;
  source[feature] = from;
  was_refused[feature] = 0;
}

void TrackedFrame::drop_match(size_t feature) {
  points[feature] = {};
  source[feature] = PointSource::none;
}

void TrackedFrame::refuse_match(size_t feature) {
  if (on_map(feature) && refused.size() < source.size())
    refused.push_back({static_cast<uint32_t>(feature), points[feature]});
  drop_match(feature);
  was_refused[feature] = 1;
}

void TrackedFrame::take_match(size_t feature, const TrackedFrame& earlier, size_t feature_there) {
  set_match(feature, earlier.points[feature_there], earlier.positions[feature_there], earlier.source[feature_there]);
  moved[feature] = earlier.moved[feature_there];
}

void TrackedFrame::map_points(std::vector<MapPointId>& matched) const {
  matched.clear();
  for (size_t i = 0; i < source.size(); ++i) {
    if (on_map(i)) matched.push_back(points[i]);
  }
}

int TrackedFrame::matches() const {
  return static_cast<int>(source.size() -
                          static_cast<size_t>(std::count(source.begin(), source.end(), PointSource::none)));
}

double TrackedFrame::mean_depth() const {
  double sum = 0;
  int count = 0;
  for (size_t i = 0; i < source.size(); ++i) {
    if (!on_map(i)) continue;
    sum += (T_cw * positions[i]).z();
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

// Reserves room in advance; its memory is used only when points come.
MatchedPoints::MatchedPoints() { mark_.reserve(1 << 17); }

void MatchedPoints::mark(const TrackedFrame& frame) {
  ++epoch_;
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (frame.on_map(i)) at_slot(mark_, frame.points[i].slot) = epoch_;
  }
}

}  // namespace covis
