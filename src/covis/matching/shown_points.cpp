// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/shown_points.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "covis/geometry/measurement.h"
#include "covis/matching/expected_matches.h"

namespace covis {
namespace {

// The observation that shows a point most as a camera with its centre there does; null: all are from another side.
const Observation* nearest_view(const MapPoint& point, const Map& map, const Eigen::Vector3d& centre_w) {
  constexpr double kOfDistance = 0.3;  // cosine for a unit of the logarithm of the ratio of distances
  const Observation* nearest = nullptr;
  double best = -2;
  for (const Observation& observation : point.observations) {
    const ViewChange change(point.position_w, centre_w, map.at(observation.key_frame).T_cw.centre());
    const double likeness = change.cosine - kOfDistance * std::log(change.factor);
    if (!change.is_near() || likeness <= best) continue;
    best = likeness;
    nearest = &observation;
  }
  return nearest;
}

// A keypoint of a key frame as another view should show it. p_k, p_c: its point in the cameras of both, metres.
ImageProbe::Expected expected(const Features& f, size_t i, const Eigen::Vector3d& p_k, const Eigen::Vector3d& p_c,
                              const Eigen::Matrix3d& R_ck) {
  ImageProbe::Expected point{.p_c = p_c};
  point.scale = f.pyramid->scale[f.level[i]] * static_cast<float>(p_k.norm() / p_c.norm());
  // A step in the key frame's image along its orientation, seen by the other camera.
  const double angle = f.angle[i];
  const Eigen::Vector3d step = R_ck * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
  const Eigen::Vector2d seen = step.head<2>() - p_c.head<2>() * (step.z() / p_c.z());
  point.angle = static_cast<float>(std::atan2(seen.y(), seen.x()));
  return point;
}

}  // namespace

void ShownPoints::add(const MapPoint& point, const Map& map) {
  const Eigen::Vector3d p_c = T_cw_ * point.position_w;
  const Observation* view = p_c.z() > kMinDepth ? nearest_view(point, map, T_cw_.centre()) : nullptr;
  if (!view) return;
  const KeyFrame& key_frame = map.at(view->key_frame);
  const Features& f = *key_frame.features;
  const Eigen::Matrix3d R_ck = T_cw_.R() * key_frame.T_cw.R().transpose();
  questions_.push_back(
      {f.descriptor[view->feature], expected(f, view->feature, key_frame.T_cw * point.position_w, p_c, R_ck)});
}

std::optional<double> ShownPoints::even_share(const ImageProbe& image) const {
  constexpr int kAgree = 88;  // Hamming distance that 5 % of other points fall below
  constexpr int kColumns = 10, kRows = 8;
  constexpr int kFull = 3;  // points with which a block counts in full
  constexpr int kEnough = 60;
  struct Block {
    int compared = 0, agree = 0;
  };
  std::array<Block, size_t{kColumns} * kRows> blocks;
  const auto part = [](double at, double from, double to, int parts) {
    return static_cast<size_t>(std::clamp(static_cast<int>((at - from) / (to - from) * parts), 0, parts - 1));
  };
  int compared = 0;
  for (const Question& question : questions_) {
    const auto distance = image.distance(question.descriptor, question.point, camera_);
    if (!distance) continue;
    const Eigen::Vector2d at = camera_.project(question.point.p_c);
    Block& block = blocks[part(at.y(), bounds_.min_y, bounds_.max_y, kRows) * kColumns +
                          part(at.x(), bounds_.min_x, bounds_.max_x, kColumns)];
    ++block.compared;
    block.agree += *distance < kAgree;
    ++compared;
  }
  if (compared < kEnough) return std::nullopt;
  double sum = 0, weights = 0;
  for (const Block& block : blocks) {
    if (block.compared == 0) continue;
    const int weight = std::min(block.compared, kFull);
    sum += weight * std::sqrt(static_cast<double>(block.agree) / block.compared);
    weights += weight;
  }
  return (sum / weights) * (sum / weights);
}

}  // namespace covis
