// SPDX-License-Identifier: Apache-2.0
// The map as the viewer shows it: one immutable value of plain rows, so that two of them can be compared.
#pragma once

#include <cstdint>
#include <vector>

#include "apps/view/rows.h"
#include "covis/slam/snapshot.h"

namespace covis::view {

struct MapScene {
  std::vector<CameraRow> cameras;       // that the key frames refer to
  std::vector<KeyFrameRow> key_frames;  // by rising id
  std::vector<PointRow> points;         // by rising id
  std::vector<EdgeRow> edges;           // by rising (a, b)
  std::vector<PathRow> path;            // by rising frame
  // The observations of key_frames[k] are entries first_observation[k] to first_observation[k + 1] (without).
  std::vector<uint32_t> first_observation;
  std::vector<ObservationRow> observations;  // other: id of the point

  const KeyFrameRow* key_frame(uint32_t id) const;  // null: there is none
};

MapScene scene_of(const Snapshot& snapshot);

// The observations of one key frame, and of one point; other: id of the point, and of the key frame.
std::vector<ObservationRow> observations_of_key_frame(const MapScene& scene, uint32_t id);
std::vector<ObservationRow> observations_of_point(const MapScene& scene, uint32_t id);

}  // namespace covis::view
