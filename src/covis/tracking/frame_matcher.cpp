// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/frame_matcher.h"

#include <algorithm>

#include "covis/core/random.h"
#include "covis/core/reserve.h"
#include "covis/geometry/pnp.h"
#include "covis/matching/point_geometry.h"

namespace covis {
namespace {

// With depth the scale of a motion is known: a camera that moves along its axis by more than its baseline, or than a
// share of its depth, sees a point larger, or smaller, than it did.
LevelRule levels_after(const TrackedFrame& last, const TrackedFrame& frame, const Pinhole& camera, double depth) {
  constexpr double kShare = 0.03;
  if (!(camera.bf > 0)) return LevelRule::around_seen;
  const double least = camera.depth_noise.known() ? kShare * depth : camera.baseline();
  const double forward = (last.T_cw * frame.T_cw.centre()).z();
  if (forward > least) return LevelRule::seen_or_larger;
  if (-forward > least) return LevelRule::seen_or_finer;
  return LevelRule::around_seen;
}

}  // namespace

// Reserves room in advance; its memory is used only when points come.
FrameMatcher::FrameMatcher() {
  constexpr size_t kFeatures = 1 << 12, kLocalPoints = 1 << 14;
  known_.reserve(kLocalPoints);
  seen_.reserve(kFeatures);
  seen_by_.reserve(kFeatures);
  seen_angle_.reserve(kFeatures);
  seen_depth_.reserve(kFeatures);
  observations_.reserve(kFeatures);
  observed_by_.reserve(kFeatures);
  inlier_.reserve(kFeatures);
}

FrameMatcher::LastFrameMatches FrameMatcher::match_last_frame(const TrackedFrame& last, TrackedFrame& frame,
                                                              const Pinhole& camera, double window) {
  const Features& from = *last.features;
  // A key frame may be of another pyramid: a level of this frame's that shows things as large is taken.
  const bool same_levels =
      from.pyramid->levels == frame.features->pyramid->levels && from.pyramid->base == frame.features->pyramid->base;
  const auto level_here = [&](size_t i) {
    return same_levels ? from.level[i] : frame.features->pyramid->predict_level(from.pyramid->scale[from.level[i]], 1);
  };
  seen_.clear();
  seen_by_.clear();
  seen_angle_.clear();
  seen_depth_.clear();
  for (size_t i = 0; i < last.source.size(); ++i) {
    if (last.source[i] == PointSource::none) continue;
    if (camera.depth_noise.known()) seen_depth_.push_back((last.T_cw * last.positions[i]).z());
    seen_.add_seen(last.points[i], last.positions[i], from.descriptor[i], level_here(i));
    seen_by_.push_back(static_cast<uint32_t>(i));
    seen_angle_.push_back(from.angle[i]);
  }
  const auto middle = seen_depth_.begin() + static_cast<ptrdiff_t>(seen_depth_.size() / 2);
  std::nth_element(seen_depth_.begin(), middle, seen_depth_.end());
  const LevelRule levels = levels_after(last, frame, camera, seen_depth_.empty() ? 0 : *middle);
  const int in_view =
      projection_.match(seen_, {camera, *frame.features, frame.T_cw}, MatchGate::last_frame(window, levels));
  const int kept = projection_.keep_consistent_rotations(seen_angle_, *frame.features);
  frame.clear_matches();
  for (const PointMatch& m : projection_.matches()) {
    frame.take_match(m.feature, last, seen_by_[m.point]);
  }
  return {in_view, kept};
}

int FrameMatcher::match_frame(const TrackedFrame& last, TrackedFrame& frame, const DescriptorMatchOptions& options) {
  std::vector<uint8_t> has_point(last.source.size());
  for (size_t i = 0; i < has_point.size(); ++i) has_point[i] = last.source[i] != PointSource::none;
  const std::vector<FeatureMatch> matches = match_descriptors(*frame.features, {}, *last.features, has_point, options);
  frame.clear_matches();
  for (const FeatureMatch& m : matches) {
    frame.take_match(static_cast<size_t>(m.a), last, static_cast<size_t>(m.b));
  }
  return static_cast<int>(matches.size());
}

int FrameMatcher::match_key_frame(const KeyFrameView& view, TrackedFrame& frame,
                                  const DescriptorMatchOptions& options) {
  const std::vector<FeatureMatch> matches =
      match_descriptors(*frame.features, {}, *view.features, features_with_point(view.points), options);
  frame.clear_matches();
  for (const FeatureMatch& m : matches) {
    const auto b = static_cast<size_t>(m.b);
    frame.set_match(static_cast<size_t>(m.a), view.points[b], view.positions[b], PointSource::map);
  }
  return static_cast<int>(matches.size());
}

int FrameMatcher::match_local_map(const LocalMap& local_map, TrackedFrame& frame, const Pinhole& camera,
                                  const MatchGate& gate) {
  const PointSet& points = local_map.points;
  matched_.mark(frame);
  reserve_ahead(taken_, frame.source.size());
  taken_.resize(frame.source.size());
  for (size_t i = 0; i < taken_.size(); ++i) taken_[i] = frame.on_map(i);
  reserve_ahead(known_, points.size());
  known_.resize(points.size());
  for (size_t k = 0; k < known_.size(); ++k) known_[k] = matched_.contains(points.id[k]);
  const int in_view = projection_.match(points, {camera, *frame.features, frame.T_cw}, gate, known_, taken_);
  for (const PointMatch& m : projection_.matches()) {
    frame.set_match(m.feature, points.id[m.point], points.position(m.point), PointSource::map);
  }
  return in_view;
}

bool FrameMatcher::find_pose(TrackedFrame& frame, const Pinhole& camera, int seed) {
  const Features& f = *frame.features;
  PnpProblem problem;
  std::vector<size_t> feature;
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (frame.source[i] == PointSource::none) continue;
    problem.add(frame.positions[i], camera.unproject(f.x[i], f.y[i]), f.pyramid->sigma2[f.level[i]]);
    feature.push_back(i);
  }
  const uint64_t frame_seed =
      hash_seed(static_cast<uint64_t>(seed), RandomStage::relocalisation, static_cast<uint64_t>(frame.index));
  const auto pose = ransac_pnp(problem, camera, frame_seed);
  if (!pose) return false;
  frame.T_cw = pose->T_cw;
  for (size_t k = 0; k < feature.size(); ++k) {
    if (!pose->inlier[k]) frame.drop_match(feature[k]);
  }
  return true;
}

namespace {

// The matches that a pose is first fitted to.
struct Leading {
  enum class Who { settled, map, all };  // settled: those of the map's points that are not new
  Who who = Who::all;
  bool still = false;  // none of them on a thing that moves by itself

  bool includes(const TrackedFrame& frame, size_t i, const LocalMap& local_map) const {
    if (still && frame.moves(i)) return false;
    if (who == Who::all) return true;
    return frame.on_map(i) && (who == Who::map || !local_map.is_new(frame.points[i]));
  }
};

// Two key frames seldom agree on a point that moves, and fewer such points are in the map than among the last frame's
// depths, which a motion of a pixel a frame does not contradict (docs/notes/061-things-that-move.md).
Leading leading(const TrackedFrame& frame, const LocalMap& local_map) {
  constexpr int kEnough = 50;
  constexpr double kShare = 0.3;  // a few settled points side by side would make the pose less sure
  struct Count {
    int settled = 0, on_map = 0;
  } all, still;
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (!frame.on_map(i)) continue;
    const bool settled = !local_map.is_new(frame.points[i]);
    ++all.on_map;
    all.settled += settled;
    if (frame.moves(i)) continue;
    ++still.on_map;
    still.settled += settled;
  }
  Leading result;
  result.still = still.on_map >= kEnough;
  const Count& count = result.still ? still : all;
  if (count.on_map >= kEnough) result.who = Leading::Who::map;
  if (count.settled >= kEnough && count.settled >= kShare * count.on_map) result.who = Leading::Who::settled;
  return result;
}

}  // namespace

int FrameMatcher::fit_pose(TrackedFrame& frame, const LocalMap& local_map, const Pinhole& camera) {
  observations_.clear();
  observed_by_.clear();
  const Features& f = *frame.features;
  const Leading leads = leading(frame, local_map);
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (frame.source[i] == PointSource::none) continue;
    if (leads.still && frame.moves(i) && !frame.on_map(i)) {
      frame.refuse_match(i);
      continue;
    }
    observations_.add(frame.positions[i], f.x[i], f.y[i], f.pyramid->inv_sigma2[f.level[i]], disparity_of(f, i, camera),
                      leads.includes(frame, i, local_map));
    observed_by_.push_back(static_cast<uint32_t>(i));
  }
  reserve_ahead(inlier_, observed_by_.size());
  const PoseResult pose = optimize_pose(frame.T_cw, observations_, camera, {}, inlier_);
  frame.information = pose.ok ? pose.information : Matrix6d::Zero();
  if (!pose.ok) return 0;
  frame.T_cw = pose.T_cw;
  int on_map = 0;
  for (size_t k = 0; k < observed_by_.size(); ++k) {
    const size_t i = observed_by_[k];
    if (!inlier_[k]) {
      frame.refuse_match(i);
    } else if (frame.on_map(i)) {
      ++on_map;
    }
  }
  return on_map;
}

}  // namespace covis
