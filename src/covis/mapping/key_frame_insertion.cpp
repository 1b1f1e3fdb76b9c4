// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/key_frame_insertion.h"

#include <memory>
#include <optional>
#include <utility>

#include "covis/features/straightening.h"
#include "covis/map/map_edit.h"
#include "covis/matching/point_geometry.h"

namespace covis {

KeyFrameId insert_key_frame(SharedMap& shared, const KeyFrameRequest& request, RecentPoints& recent) {
  const FeaturesPtr features =
      key_frame_features(*request.features, request.depth, request.turn_rate, shared.read()->camera());
  MapEdit map(shared);
  SE3 T_cw = request.pose.T_cr;
  std::optional<RelativePose> reference;
  if (request.pose.key_frame.valid()) {
    reference = request.pose.resolved(*map);
    if (!reference) return {};
    T_cw = reference->T_cw(*map).normalized();
  }
  for (const PointCount& count : request.counts) {
    const MapPointId point = map->forwarded(count.point);
    if (!point.valid()) continue;
    map.map().count_visible(point, count.visible);
    map.map().count_found(point, count.found);
  }
  const KeyFrameId id = reference ? map.map().add_key_frame(request.frame, request.stamp, T_cw, features,
                                                            map->at(reference->key_frame).submap)
                                  : map.map().begin_submap(request.frame, request.stamp, T_cw, features);
  if (!id.valid()) return id;
  for (uint32_t feature = 0; feature < request.points.size(); ++feature) {
    const MapPointId point = map->forwarded(request.points[feature]);
    if (point.valid()) map.add_observation(point, id, feature);
  }
  const SE3 T_wc = T_cw.inverse();
  const uint32_t serial = map->at(id).serial;
  for (const uint32_t feature : request.new_points) {
    if (!features->has_depth(static_cast<int>(feature))) continue;  // it was looked up anew
    const MapPointId point = map.add_point(T_wc * unproject_depth(map->camera(), *features, feature), id, feature);
    if (point.valid()) recent.add(point, serial);
  }
  map.map().attach_to_tree(id);
  return id;
}

}  // namespace covis
