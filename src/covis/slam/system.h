// SPDX-License-Identifier: Apache-2.0
// The whole system: images in, poses and a map out. Owns the actors; the only place that makes threads beside the front
// end's.
//
// Deterministic by default (architecture.md, decision 6): mapping runs beside tracking, but what it made of a key frame
// shows to the tracker `mapping_delay` frames later, or at the next frame where few points were tracked, and the
// tracker waits for it then. Until then the tracker works on its copies of the map. So the result depends on the input
// and the settings alone.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "covis/core/error.h"
#include "covis/features/frontend.h"
#include "covis/map/shared_map.h"
#include "covis/slam/mapping_actor.h"
#include "covis/slam/options.h"
#include "covis/tracking/tracker.h"

namespace covis {

// Stages of one frame, milliseconds.
struct FrameTiming {
  double extract_ms = 0;  // features
  double depth_ms = 0;    // stereo matching or depth look-up
  double wait_ms = 0;     // for mapping (deterministic mode)
  double track_ms = 0;    // from features to pose, and asking for a key frame
  double total_ms = 0;
};

// What is kept of every frame.
struct FrameRecord {
  int64_t frame = 0;
  Timestamp stamp = 0;
  bool tracked = false;  // has a pose in the map
  bool online = false;   // had one when it was tracked (the first view of a monocular map gets its pose later)
  RelativePose pose;           // carries every later correction
  SE3 T_wc_online;             // as it was when tracked, …
  uint32_t submap_online = 0;    // … in the world of this submap
};

struct FrameReport {
  TrackResult track;
  FrameTiming timing;
  std::vector<MappingReport> mapping;  // of key frames whose mapping became visible
};

struct PoseOfFrame {
  int64_t frame = 0;
  Timestamp stamp = 0;
  SE3 T_wc;
  int submap_index = 0;  // in whose world: index into System::submaps() …
  uint32_t submap = 0;  // … and SubmapSummary::id
};

// A map of its own: a submap of the whole (Map::submaps()) as those outside see it.
struct SubmapSummary {
  uint32_t id = 0;
  bool loaded = false;  // it was put in place by set_map(), or joined to what was
  size_t frames = 0;    // of the recording that have a pose in it
  size_t key_frames = 0, points = 0;
};

class System {
 public:
  // Without a vocabulary (null) places are not recognised: no relocalisation beyond the nearest key frames, no loops.
  System(const Camera& camera, const SystemOptions& options, std::shared_ptr<const Vocabulary> vocabulary = nullptr);
  ~System();
  System(const System&) = delete;
  System& operator=(const System&) = delete;

  struct Input {
    int64_t frame = 0;                      // rises from frame to frame
    Timestamp stamp = 0;                    // rises too
    ImageView<const uint8_t> image, right;  // right: stereo only
    ImageView<const float> depth;           // RGB-D only, metres
  };
  FrameReport process(const Input& input);

  // The intrinsics in use: those of the map, which are those given, or with the focal length refined (monocular,
  // RGB-D: mapper.refine_focal).
  Pinhole camera() const { return own_camera_.value_or(map_.read()->camera()); }

  // Puts a map in place, for example a saved one: before the first frame. The camera is looked for in it. `made_by`:
  // the camera it was made with, as it was given then. A map has one camera: made by another it is an error, unless it
  // serves for localisation only.
  Result<void> set_map(Map map, const Camera& made_by);
  // Relocalisation alone: where one image was taken, from nothing but the image; nothing when its place is not
  // recognised. Waits until key frames asked for are mapped; leaves tracking and mapping as they are.
  struct Location {
    SE3 T_wc;
    uint32_t submap = 0;  // in whose world: SubmapSummary::id
  };
  std::optional<Location> locate(const Input& input);

  // Waits for mapping to end. process() may go on afterwards.
  std::vector<MappingReport> finish();

  // The submaps there are: loaded ones first, then those with more frames, then the older ones. More than one: the camera
  // was lost and the submaps made before and after were not joined (yet).
  std::vector<SubmapSummary> submaps() const;
  // Poses of all tracked frames, with every correction (final) or as they were given (online; of the first map alone).
  // World: the camera of the submap's first key frame.
  std::vector<PoseOfFrame> trajectory() const;
  std::vector<PoseOfFrame> online_trajectory() const;
  std::vector<PoseOfFrame> key_frames() const;
  const std::vector<FrameRecord>& records() const { return records_; }
  const SharedMap& map() const { return map_; }

 private:
  FeaturesPtr extract(const Input& input, bool twice_the_features);
  void collect(FrameReport& report, bool wait);
  void take(const MappingReport& report);
  void retract(int64_t from);  // the poses of this frame and later ones
  void discard(uint32_t submap);
  std::vector<SubmapSummary> submaps(const Map& map) const;
  template <class Visit>
  void for_each_pose(const Map& map, Visit&& visit) const;

  const Camera given_;
  std::optional<Pinhole> own_camera_;  // of the frames, when the map is of another camera
  const SystemOptions options_;
  const std::shared_ptr<const Vocabulary> vocabulary_;
  SharedMap map_;
  Frontend frontend_;
  Tracker tracker_;
  MappingActor mapping_;
  std::vector<FrameRecord> records_;
  int64_t processed_ = 0;   // frames so far
  int64_t visible_at_ = 0;  // count of frames at which pending mapping is taken over
};

}  // namespace covis
