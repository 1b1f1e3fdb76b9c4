// SPDX-License-Identifier: Apache-2.0
// Local mapping: the work that every new key frame asks for. Synchronous; its thread is in slam/mapping_actor.h. The
// mapper is called by the one thread that writes to the map: it reads under read guards, computes on copies, and
// commits under short write guards.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VI; Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017,
// III-C.
#pragma once

#include <atomic>
#include <memory>
#include <utility>

#include "covis/map/shared_map.h"
#include "covis/mapping/depth_noise_tracker.h"
#include "covis/mapping/mapper_options.h"
#include "covis/mapping/mapping_report.h"
#include "covis/mapping/recent_points.h"
#include "covis/matching/point_fuser.h"
#include "covis/optimization/bundle_adjustment.h"

namespace covis {

class Mapper {
 public:
  // `close_depth`: up to where a depth is close (culling of key frames). Without a vocabulary (null) key
  // frames have no words.
  Mapper(SharedMap& map, Sensor sensor, const MapperOptions& options, const CloseDepth& close_depth,
         std::shared_ptr<const Vocabulary> vocabulary = nullptr)
      : map_(map), sensor_(sensor), options_(options), close_depth_(close_depth), vocabulary_(std::move(vocabulary)) {}

  // The whole of local mapping for one key frame. `interrupt` (may be null) becomes true when another waits: bundle
  // adjustment is then cut short.
  MapperReport process(const KeyFrameRequest& request, const std::atomic<bool>* interrupt);
  // Two key frames and their points, adjusted and scaled to a median depth of 1, as a new submap. The report's
  // key frame is invalid, and the map unchanged, when too little survives.
  MapperReport initialise(const InitialMapRequest& request);

 private:
  void add_words(KeyFrameId id);
  bool enough_to_adjust(KeyFrameId id) const;

  SharedMap& map_;
  const Sensor sensor_;
  const MapperOptions options_;
  const CloseDepth close_depth_;
  const std::shared_ptr<const Vocabulary> vocabulary_;
  RecentPoints recent_;
  BundleAdjuster adjuster_;
  DepthNoiseTracker depth_noise_;
  PointFuser fuser_;
};

}  // namespace covis
