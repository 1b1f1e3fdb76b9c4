// SPDX-License-Identifier: Apache-2.0
// Fuses duplicate points of a new key frame and its neighbourhood.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VI-C; Mur-Artal and Tardós, "ORB-SLAM2", T-RO
// 2017, III-C.
#pragma once

#include "covis/map/shared_map.h"
#include "covis/mapping/mapper_options.h"
#include "covis/matching/point_fuser.h"

namespace covis {

// The key frame's points are searched in its neighbours and theirs, and the points of these in the key frame. Returns
// the number of points fused or observations added.
int fuse_neighbours(SharedMap& map, KeyFrameId current, Sensor sensor, const MapperOptions& options, PointFuser& fuser);

// The same without refresh_points_of(current), so that several key frames share one, and a memory of searches that
// found nothing.
int fuse_neighbours_unrefreshed(SharedMap& map, KeyFrameId current, Sensor sensor, const MapperOptions& options,
                                PointFuser& fuser, FuseMemory* memory = nullptr);

}  // namespace covis
