// SPDX-License-Identifier: Apache-2.0
// Erases key frames that show nothing others do not show as well.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VI-E; close points alone: Mur-Artal and Tardós,
// "ORB-SLAM2", T-RO 2017, III-C.
#pragma once

#include "covis/core/sensor.h"
#include "covis/map/shared_map.h"

namespace covis {

// Erases the key frames beside `current` whose redundancy exceeds `max_redundancy`, one after the other, as each one's
// points count for the next. The redundancy is the share of a key frame's points that at least three other key frames
// observe at a scale that is at most one level coarser; with a depth sensor only its points up to `close_depth` count,
// and a key frame without any stays. Roots and key frames with loop edges stay. Returns the number erased.
int cull_key_frames(SharedMap& map, KeyFrameId current, Sensor sensor, double max_redundancy,
                    const CloseDepth& close_depth);

}  // namespace covis
