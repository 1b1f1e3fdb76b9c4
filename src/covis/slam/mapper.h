// SPDX-License-Identifier: Apache-2.0
// Local mapping: what is done for every new key frame. Synchronous; its thread is in mapping_actor.h. The mapper is the
// map's only writer: it reads under read guards, computes on copies, and commits under short write guards.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VI; Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017,
// III-C.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "covis/map/shared_map.h"
#include "covis/optimization/bundle_adjustment.h"
#include "covis/slam/focal_refinement.h"
#include "covis/slam/global_adjuster.h"
#include "covis/slam/loop_closer.h"
#include "covis/slam/messages.h"
#include "covis/slam/options.h"
#include "covis/matching/point_fuser.h"

namespace covis {

class Mapper {
 public:
  // The map has the camera it was given. Without a vocabulary (null) key frames have no words and places are not
  // recognised.
  Mapper(SharedMap& map, const SystemOptions& options, std::shared_ptr<const Vocabulary> vocabulary = nullptr)
      : map_(map),
        options_(options),
        vocabulary_(std::move(vocabulary)),
        closer_(map, options),
        given_fx_(map.read()->camera().fx) {}

  // The whole of local mapping for one key frame. `interrupt` (may be null) becomes true when another waits: bundle
  // adjustment is then cut short.
  MappingReport process(const KeyFrameRequest& request, const std::atomic<bool>* interrupt);
  // Two key frames and their points, adjusted and scaled to a median depth of 1, as a new submap. The report's
  // key frame is invalid, and nothing made, when too little survives.
  MappingReport initialise(const InitialMapRequest& request);
  // Waits for what runs in the background and takes it over.
  void finish();
  // A submap is forgotten (a monocular one that failed in its first moments).
  void discard(uint32_t submap);

 private:
  struct Recent {
    MapPointId point;
    uint32_t serial = 0;  // of the key frame it was made with
  };

  KeyFrameId insert(const KeyFrameRequest& request);
  size_t key_frames_of_its_submap(KeyFrameId id) const;
  void add_words(KeyFrameId id);
  int cull_recent_points(KeyFrameId current);
  int create_points(KeyFrameId current);
  int fuse_neighbours(KeyFrameId current);
  void local_bundle_adjustment(KeyFrameId current, const std::atomic<bool>* interrupt, MappingReport& report);
  int cull_key_frames(KeyFrameId current);
  void close_loop(KeyFrameId current, MappingReport& report);
  void take_over_adjustment(MappingReport& report);
  void adjust_focal(KeyFrameId current);

  bool monocular() const { return options_.sensor == Sensor::monocular; }

  SharedMap& map_;
  const SystemOptions options_;
  const std::shared_ptr<const Vocabulary> vocabulary_;
  std::vector<Recent> recent_;
  LoopCloser closer_;
  GlobalAdjuster global_;
  int global_left_ = 0;  // key frames until its result is taken over
  FocalSchedule focal_;
  const double given_fx_;  // the focal length the camera came with, pixels
  BundleAdjuster adjuster_;
  PointFuser fuser_;
};

}  // namespace covis
