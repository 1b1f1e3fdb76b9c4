// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_matches.h"

#include <algorithm>
#include <utility>

#include "covis/matching/descriptor_match.h"

namespace covis {
namespace {

constexpr float kRatio = 0.75f;

// For each feature of the current key frame the place's point that looks most like it, or an invalid handle.
std::vector<MapPointId> match_descriptors(const LoopCandidate& candidate) {
  const KeyFrameView& current = candidate.current;
  std::vector<MapPointId> matched(current.points.size());
  std::vector<int> distance(current.points.size(), kHammingBeyond);
  const std::vector<uint8_t> has_point = features_with_point(current.points);
  for (const KeyFrameView& member : candidate.members) {
    for (const FeatureMatch& m :
         match_descriptors(*current.features, has_point, *member.features, features_with_point(member.points),
                           {.max_distance = kHammingLow, .ratio = kRatio})) {
      const auto a = static_cast<size_t>(m.a), b = static_cast<size_t>(m.b);
      const int d = hamming(current.features->descriptor[a], member.features->descriptor[b]);
      if (d >= distance[a] || member.points[b] == current.points[a]) continue;
      distance[a] = d;
      matched[a] = member.points[b];
    }
  }
  return matched;
}

// A point of the place, and what the current key frame takes for it.
struct Pair {
  MapPointId here, there;
  Eigen::Vector3d p_here_w, p_there_w;  // each in its own world
  float d_max_here = 0, d_max_there = 0;
  friend bool operator<(const Pair& a, const Pair& b) { return a.here != b.here ? a.here < b.here : a.there < b.there; }
};

// Measurements of one of both views: each point by the feature that sees it, else by its projection. Others of the
// group may see a point where the key frame itself does not.
class Measurements {
 public:
  Measurements(const KeyFrameView& view, const Pinhole& camera) : view_(view), camera_(camera) {
    for (uint32_t f = 0; f < view.points.size(); ++f) {
      if (view.points[f].valid()) seen_.emplace_back(view.points[f], f);
    }
    std::sort(seen_.begin(), seen_.end());
  }
  // False for a point behind the camera.
  bool measure(MapPointId point, const Eigen::Vector3d& position_w, float d_max, Eigen::Vector3d& p_c,
               Eigen::Vector2d& z, double& inv_sigma2) const {
    p_c = view_.T_cw * position_w;
    if (!(p_c.z() > 0)) return false;
    const Features& f = *view_.features;
    const auto seen = std::lower_bound(seen_.begin(), seen_.end(), std::pair{point, uint32_t{0}});
    if (seen != seen_.end() && seen->first == point) {
      z = {f.x[seen->second], f.y[seen->second]};
      inv_sigma2 = f.pyramid->inv_sigma2[f.level[seen->second]];
    } else {
      z = camera_.project(p_c);
      const int level = f.pyramid->predict_level(d_max, static_cast<float>(p_c.norm()));
      inv_sigma2 = f.pyramid->inv_sigma2[static_cast<size_t>(level)];
    }
    return true;
  }

 private:
  const KeyFrameView& view_;
  const Pinhole& camera_;
  std::vector<std::pair<MapPointId, uint32_t>> seen_;  // sorted
};

std::vector<Sim3Match> measure(const LoopCandidate& candidate, const std::vector<Pair>& pairs) {
  const Measurements here(candidate.current, candidate.camera), there(candidate.members.front(), candidate.camera);
  std::vector<Sim3Match> matches;
  for (const Pair& pair : pairs) {
    Sim3Match m;
    if (here.measure(pair.here, pair.p_here_w, pair.d_max_here, m.p_1, m.z_1, m.inv_sigma2_1) &&
        there.measure(pair.there, pair.p_there_w, pair.d_max_there, m.p_2, m.z_2, m.inv_sigma2_2))
      matches.push_back(m);
  }
  return matches;
}

}  // namespace

std::vector<Sim3Match> match_by_descriptor(const LoopCandidate& candidate) {
  if (candidate.members.empty()) return {};
  const KeyFrameView& current = candidate.current;
  const PointSet& points = candidate.place.points;
  const std::vector<MapPointId> matched = match_descriptors(candidate);
  std::vector<Pair> pairs;
  for (size_t i = 0; i < matched.size(); ++i) {
    const int32_t at = matched[i].valid() ? index_of(points, matched[i]) : -1;
    const int32_t own = index_of(candidate.here.points, current.points[i]);
    if (at < 0 || own < 0) continue;
    const auto p = static_cast<size_t>(at);
    pairs.push_back({current.points[i], matched[i], current.positions[i], points.position(p),
                     candidate.here.points.d_max[static_cast<size_t>(own)], points.d_max[p]});
  }
  return measure(candidate, pairs);
}

std::vector<Sim3Match> match_both_ways(const LoopCandidate& candidate, const std::vector<PointMatch>& here,
                                       const std::vector<PointMatch>& there) {
  const KeyFrameView &current = candidate.current, &place = candidate.members.front();
  const PointSet &points_here = candidate.here.points, &points_there = candidate.place.points;
  std::vector<Pair> pairs;
  const auto add = [&](MapPointId id_here, MapPointId id_there) {
    if (!id_here.valid() || !id_there.valid() || id_here == id_there) return;
    const int32_t h = index_of(points_here, id_here), t = index_of(points_there, id_there);
    if (h < 0 || t < 0) return;
    const auto a = static_cast<size_t>(h), b = static_cast<size_t>(t);
    pairs.push_back({id_here, id_there, points_here.position(a), points_there.position(b), points_here.d_max[a],
                     points_there.d_max[b]});
  };
  for (const PointMatch& match : here) add(current.points[match.feature], points_there.id[match.point]);
  for (const PointMatch& match : there) add(points_here.id[match.point], place.points[match.feature]);
  const auto same = [](const Pair& a, const Pair& b) { return a.here == b.here && a.there == b.there; };
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end(), same), pairs.end());
  return measure(candidate, pairs);
}

}  // namespace covis
