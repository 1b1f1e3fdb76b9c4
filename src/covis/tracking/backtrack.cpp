// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/backtrack.h"

#include "covis/tracking/first_pose.h"
#include "covis/tracking/match_belief.h"
#include "covis/tracking/motion_model.h"

namespace covis {
namespace {

class Walk {
 public:
  Walk(const SharedMap& map, const BacktrackSettings& settings)
      : map_(map),
        options_(settings.options),
        sensor_(settings.sensor),
        search_(options_.recovery, Subject::single_image),
        first_pose_(settings.sensor, options_.first_pose, FirstPose::Support::map_points, settings.seed) {
    search_.refresh_camera(*map.read());
  }

  // Begins at a key frame. False: it is not in the map any more.
  bool begin_at(KeyFrameId key_frame);
  // Finds the pose of a frame from the last one that was found.
  std::optional<RelativePose> step(const UnlocatedFrame& frame);

 private:
  bool find_pose();

  const SharedMap& map_;
  const TrackerOptions& options_;
  const Sensor sensor_;
  PoseSearch search_;
  FirstPose first_pose_;
  MotionModel motion_;
  MatchBelief belief_;
  TrackedFrame last_, current_;
  KeyFrameId reference_;  // that of the last frame
};

bool Walk::begin_at(KeyFrameId near) {
  const auto map = map_.read();
  const auto resolved = map->resolve(near);
  if (!resolved) return false;
  const KeyFrame& key_frame = map->at(resolved->key_frame);
  reference_ = resolved->key_frame;
  KeyFrameView& view = search_.local_map.reference;
  view.copy(*map, reference_);
  last_.start(view.features, key_frame.frame, key_frame.stamp);
  last_.T_cw = view.T_cw;
  for (size_t i = 0; i < view.points.size(); ++i) {
    if (view.points[i].valid()) last_.set_match(i, view.points[i], view.positions[i], PointSource::map);
  }
  motion_.reset();
  return true;
}

bool Walk::find_pose() {
  TrackResult figures;
  const std::optional<SE3> T_cl = motion_.predict(current_.stamp - last_.stamp);
  if (!first_pose_.find(last_, T_cl, current_, search_, figures)) return false;
  const LocalMapOptions& o = options_.local_map;
  search_.update_local_map(map_, current_, reference_, o.local_key_frames);
  search_.fit_local_map(o, o.window_factor(sensor_), current_, figures);
  const bool by_motion = figures.method == TrackMethod::motion_model || figures.method == TrackMethod::image_rotation;
  if (figures.inliers < (by_motion ? o.min_inliers : options_.recovery.min_inliers_recovered) ||
      !well_determined(current_.information, current_.mean_depth(), search_.camera) ||
      !belief_.explains_view(figures, first_pose_.images_agree(current_.T_cw * last_.T_cw.inverse())))
    return false;
  if (!by_motion && !search_.place.is_right(search_.found(current_, &map_), Arrival::relocalised)) return false;
  belief_.accept(figures);
  return true;
}

std::optional<RelativePose> Walk::step(const UnlocatedFrame& frame) {
  current_.start(frame.features, frame.frame, frame.stamp);
  current_.straighten_for(search_.camera);
  if (!find_pose()) {
    if (const auto map = map_.read(); map->find(reference_)) search_.local_map.reference.copy(*map, reference_);
    return std::nullopt;
  }
  if (current_.stamp != last_.stamp)
    motion_.observe((current_.T_cw * last_.T_cw.inverse()).normalized(), current_.stamp - last_.stamp);
  std::swap(last_, current_);
  const KeyFrameView& reference = search_.local_map.reference;
  reference_ = reference.id;
  return RelativePose{reference.id, reference.scale, last_.T_cw * reference.T_cw.inverse()};
}

}  // namespace

Backtracked backtrack(const SharedMap& map, const BacktrackSettings& settings,
                      const std::vector<UnlocatedFrame>& frames) {
  constexpr int kPatience = 5;  // frames in a row that may fail
  Backtracked found;
  if (frames.empty()) return found;
  Walk walk(map, settings);
  KeyFrameId near;
  int failed = 0;
  for (const UnlocatedFrame& frame : frames) {
    if (!(frame.near == near)) {
      near = frame.near;
      failed = walk.begin_at(near) ? 0 : kPatience;
    }
    if (const auto pose = failed < kPatience ? walk.step(frame) : std::nullopt) {
      found.located.push_back({frame.frame, *pose});
      failed = 0;
    } else {
      found.left.push_back(frame);
      ++failed;
    }
  }
  return found;
}

}  // namespace covis
