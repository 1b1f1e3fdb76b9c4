// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/registration_refinement.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <tuple>

#include "covis/core/log.h"
#include "covis/core/quantile.h"
#include "covis/features/straightening.h"
#include "covis/geometry/triangulation.h"
#include "covis/loops/submap_adjustment.h"
#include "covis/map/camera_change.h"
#include "covis/matching/epipolar_match.h"
#include "covis/matching/point_geometry.h"
#include "covis/optimization/depth_noise_estimation.h"
#include "covis/optimization/lens_adjustment.h"

namespace covis {
namespace {

constexpr int kLeastViews = 3;  // two views fit nearly any point

// All depths of key frames can. Some have none, as where depth contradicted the map.
bool can_be_looked_up(const Map& map) {
  bool all = true;
  map.for_each_key_frame([&](KeyFrameId, const KeyFrame& key_frame) {
    const Features& f = *key_frame.features;
    all &= f.kept_depth || !f.has_any_depth();
  });
  return all;
}

// A key frame as its image alone tells it.
struct View {
  SE3 T_cw;
  FeaturesPtr features;
  int number = 0;
  double depth = 0;  // median, metres; 0: none was measured

  View(const SE3& pose, FeaturesPtr of, int n) : T_cw(pose), features(std::move(of)), number(n) {
    std::vector<double> depths;
    for (const float z : features->depth)
      if (z > 0) depths.push_back(static_cast<double>(z));
    depth = quantile(std::move(depths), 0.5);
  }
};

// Points that two views show, wherever depth says that they are.
void add_sights(const View& a, const View& b, const Pinhole& camera, std::vector<DepthSight>& sights) {
  constexpr double kMostAlike = 0.9990;  // cosine of 2.5 degrees
  constexpr EpipolarMatchOptions kSure{.max_ratio = 0.7, .max_chi2 = 1};
  const SE3 T_ba = b.T_cw * a.T_cw.inverse();
  for (const FeatureMatch& m : match_epipolar(camera, *a.features, {}, *b.features, {}, T_ba, kSure)) {
    const auto ia = static_cast<size_t>(m.a), ib = static_cast<size_t>(m.b);
    const Eigen::Vector3d ray_a = camera.unproject(a.features->x[ia], a.features->y[ia]);
    const Eigen::Vector3d ray_b = camera.unproject(b.features->x[ib], b.features->y[ib]);
    if ((T_ba.R() * ray_a).normalized().dot(ray_b.normalized()) > kMostAlike) continue;
    const auto p_a = triangulate(SE3(), ray_a, T_ba, ray_b);
    if (!p_a) continue;
    const Eigen::Vector3d p_b = T_ba * *p_a;
    if (!(p_a->z() > kMinDepth) || !(p_b.z() > kMinDepth)) continue;
    for (const auto& [view, i, z] : {std::tuple(&a, ia, p_a->z()), std::tuple(&b, ib, p_b.z())}) {
      const Features& f = *view->features;
      sights.push_back({.depth = f.kept_depth.get(),
                        .image = {f.image_x()[i], f.image_y()[i]},
                        .pixel = f.pinhole_pixel(i).cast<float>(),
                        .z = static_cast<float>(z),
                        .view = a.number});
    }
  }
}

// Points that one key frame alone sees, and whose depth it measures no more.
std::vector<std::pair<MapPointId, KeyFrameId>> unmeasured(const Map& map) {
  std::vector<std::pair<MapPointId, KeyFrameId>> found;
  map.for_each_point([&](MapPointId id, const MapPoint& point) {
    const Observation& seen = point.observations.front();
    if (point.observations.size() == 1 && !map.at(seen.key_frame).features->has_depth(static_cast<int>(seen.feature)))
      found.emplace_back(id, seen.key_frame);
  });
  return found;
}

}  // namespace

bool RegistrationSchedule::ask(const Map& map) {
  const uint32_t serial = map.next_serial();
  // The answer may come a key frame later, which has to keep its depth image too.
  if (serial < next_ || serial + 1 >= kLast || map.camera().registration.any() || map.submaps().size() != 1 ||
      has_other_cameras(map) || !can_be_looked_up(map))
    return false;
  next_ = serial + serial / 2;
  return true;
}

void RegistrationSchedule::drop_depths(SharedMap& shared) {
  std::vector<std::pair<KeyFrameId, FeaturesPtr>> made;
  const auto collect = [&](const Map& map) {
    constexpr uint32_t kAllCame = 2 * kLast;  // also those that were under way
    if (map.next_serial() < kLast || map.next_serial() > kAllCame) return;
    map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
      if (!key_frame.features->kept_depth) return;
      auto features = std::make_shared<Features>(*key_frame.features);
      features->kept_depth = nullptr;
      made.emplace_back(id, std::move(features));
    });
  };
  collect(*shared.read());
  if (made.empty()) return;
  const auto map = shared.write();
  for (auto& [id, features] : made) map->set_features(id, std::move(features));
}

std::unique_ptr<RegistrationRefinement> RegistrationRefinement::of(const Map& map, KeyFrameId key_frame,
                                                                   const LearnedOfDepth& learned) {
  std::optional<MapProblem> submap = copy_submap(map, key_frame);
  if (!submap) return nullptr;
  auto job = std::unique_ptr<RegistrationRefinement>(new RegistrationRefinement(std::move(*submap), learned));
  for (const KeyFrameId& id : job->submap_.key_frames) job->features_.push_back(map.at(id).features);
  for (const BundleObservation& o : job->submap_.problem.observations) {
    const MapPoint& point = map.at(job->submap_.points[static_cast<size_t>(o.point)]);
    job->feature_.push_back(point.feature_in(job->submap_.key_frames[static_cast<size_t>(o.pose)]));
  }
  return job;
}

// Keypoints are matched anew: the map has those that agree with depth where it was looked up.
std::vector<DepthSight> RegistrationRefinement::sights(const BundleProblem& problem,
                                                       const std::atomic<bool>& interrupt) const {
  constexpr int kPartners = 3;                          // key frames that each is paired with
  constexpr double kLeastBase = 0.05, kMostBase = 0.5;  // shares of the depth
  std::vector<View> views;
  for (size_t k = 0; k < features_.size(); ++k)
    if (features_[k]->kept_depth)
      views.emplace_back(problem.poses[k], straightened(*features_[k], problem.camera), static_cast<int>(k));
  std::vector<DepthSight> sights;
  for (size_t a = 0; a < views.size() && !interrupt; ++a) {
    int partners = 0;
    for (size_t b = a + 1; b < views.size() && partners < kPartners; ++b) {
      const double base = (views[a].T_cw.inverse().t() - views[b].T_cw.inverse().t()).norm();
      if (!(base > kLeastBase * views[a].depth) || base > kMostBase * views[a].depth) continue;
      add_sights(views[a], views[b], problem.camera, sights);
      ++partners;
    }
  }
  return sights;
}

// The problem as the images alone tell it, in the same unit, with the focal length that was given and whatever
// distortion was not. Nothing: they do not tell it.
std::optional<BundleProblem> RegistrationRefinement::without_depth(const std::atomic<bool>& interrupt) const {
  const BundleProblem& problem = submap_.problem;
  const Pinhole& camera = problem.camera;
  BundleProblem plain = problem;
  std::vector<int> observers(plain.points.size());
  for (const BundleObservation& o : plain.observations) ++observers[static_cast<size_t>(o.point)];
  for (BundleObservation& o : plain.observations) {
    o.disparity = {};
    o.active = observers[static_cast<size_t>(o.point)] >= kLeastViews;
    o.v = static_cast<float>(camera.cy + camera.fx / camera.fy * (static_cast<double>(o.v) - camera.cy));
  }
  plain.camera.fx = plain.camera.fy = learned_.given_fx;
  const LensAdjustment lens = adjust_lens(plain, {.focal = learned_.given_fx},
                                          {.usual_focal = 0, .interrupted = [&] { return interrupt.load(); }});
  if (!lens.ok) return std::nullopt;
  plain.camera.fy = camera.fy / camera.fx * learned_.given_fx;
  plain.camera.residual = {lens.lens.k1, lens.lens.k2};
  std::vector<double> factors;
  for (const BundleObservation& o : plain.observations) {
    const auto p = static_cast<size_t>(o.point), v = static_cast<size_t>(o.pose);
    if (o.active)
      factors.push_back((problem.poses[v] * problem.points[p]).z() / (plain.poses[v] * plain.points[p]).z());
  }
  const double factor = quantile(std::move(factors), 0.5);
  if (!(factor > 0)) return std::nullopt;
  for (SE3& T_cw : plain.poses) T_cw = SE3(T_cw.R(), Eigen::Vector3d(factor * T_cw.t()));
  return plain;
}

// By the depths of the features. What the noise of depths is changes their weights, and these change what it is.
bool RegistrationRefinement::adjust(const std::atomic<bool>& interrupt) {
  constexpr int kRounds = 3;
  BundleProblem& problem = submap_.problem;
  BundleAdjuster adjuster;
  for (int round = 0; round < kRounds; ++round) {
    for (size_t k = 0; k < problem.observations.size(); ++k) {
      BundleObservation& o = problem.observations[k];
      o.disparity = disparity_of(*features_[static_cast<size_t>(o.pose)], feature_[k], problem.camera);
      o.active = 1;
    }
    const BundleSummary summary = adjuster.solve(problem, {.iterations = 20, .interrupt = &interrupt});
    if (!summary.ok || summary.interrupted) return false;
    classify_observations(problem);
    if (!learned_.noise) break;
    DepthNoise& noise = problem.camera.depth_noise;
    noise = noise.scaled(depth_noise_factor(problem).value_or(1));
  }
  return true;
}

bool RegistrationRefinement::run(const std::atomic<bool>& interrupt) {
  // Errors as shares of that of the present registration. In a map that was made with wrong depths they differ less.
  constexpr double kSuspected = 0.92, kClearly = 0.88;
  BundleProblem& problem = submap_.problem;
  Pinhole& camera = problem.camera;
  const Eigen::Vector2d centre(camera.cx, camera.cy);
  if (!find_registration(sights(problem, interrupt), camera.registration, centre, kSuspected) || interrupt)
    return false;
  const std::optional<BundleProblem> plain = without_depth(interrupt);
  if (!plain) return false;
  const auto found = find_registration(sights(*plain, interrupt), camera.registration, centre, kClearly);
  if (!found) return false;
  camera.registration = *found;
  camera.fy *= learned_.given_fx / camera.fx;
  camera.fx = learned_.given_fx;
  for (FeaturesPtr& features : features_) features = straightened(*features, camera);
  return adjust(interrupt);
}

std::optional<KeyFrameMoves> RegistrationRefinement::apply(SharedMap& shared) const {
  const Pinhole& camera = submap_.problem.camera;
  const auto fits = [](const Map& map) { return map.submaps().size() == 1 && can_be_looked_up(map); };
  if (!fits(*shared.read())) return std::nullopt;
  auto moves = apply_submap(submap_, shared, camera);
  if (!moves) return std::nullopt;
  {
    const auto gone = unmeasured(*shared.read());
    MapEdit map(shared);
    for (const auto& [point, key_frame] : gone) map.erase_observation(point, key_frame);
  }
  log(LogLevel::info, "depth images are not registered to the images: " + description(camera.registration));
  return moves;
}

}  // namespace covis
