// SPDX-License-Identifier: Apache-2.0
// The whole system: images in, poses and a map out. It conducts: features are made, tracked, written into the log, and
// key frames handed to mapping. Its threads are mapping's
// (MappingActor), the background adjustment's, and one of the front end (stereo).
//
// Deterministic by default (architecture.md, decision 6): mapping runs beside tracking, but what it made of a key frame
// shows to the tracker `mapping_delay` frames later, or at the next frame where few points were tracked, and the
// tracker waits for it then. Until then the tracker works on its copies of the map. So the result depends on the input
// and the settings alone.
//
// One thread, the tracking thread, makes it and calls what changes it: set_map(), process(), locate(), finish(),
// set_mode(), take_warnings(), and what asks about tracking: mode(), tracked_points(), viewed_keypoints(). Any thread
// may call the other const members and colour_key_frames() at any time.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "covis/core/error.h"
#include "covis/features/frontend.h"
#include "covis/map/map_state.h"
#include "covis/map/shared_map.h"
#include "covis/slam/key_frame_colours.h"
#include "covis/slam/late_frames.h"
#include "covis/slam/mapping_actor.h"
#include "covis/slam/options.h"
#include "covis/slam/sensor_monitor.h"
#include "covis/slam/snapshot.h"
#include "covis/slam/trajectory_log.h"
#include "covis/tracking/tracker.h"

namespace covis {

// Stages of one frame, milliseconds.
struct FrameTiming {
  double extract_ms = 0;  // features
  double depth_ms = 0;    // stereo matching or depth look-up; comparison with motion while that is in doubt
  double wait_ms = 0;     // for mapping (deterministic mode)
  double track_ms = 0;    // from features to pose, and asking for a key frame
  double total_ms = 0;
};

struct FrameReport {
  TrackResult track;
  FrameTiming timing;
  std::vector<MappingReport> mapping;        // of key frames whose mapping became visible
  std::optional<Timestamp> retracted_from;   // frames from here on have lost their poses: the place proved wrong
  std::optional<uint32_t> discarded_submap;  // a monocular submap that was lost in its first moments
  std::vector<SensorWarning> warnings;       // depth that is not to be believed, each kind once
};

// The place of one image.
struct LocatedImage : SubmapPose {
  int inliers = 0;       // map points that agree with the pose
  Matrix6d information;  // of T_cw, given the map
};

// A keypoint of a frame, or a place in it where a map point was expected.
struct ViewedKeypoint {
  enum class Kind { tracked, unmatched, lost };  // shows a map point; shows none; expected, and not found
  float u = 0, v = 0;                            // pixels of the image as it was given
  Kind kind = Kind::tracked;
};

class System {
 public:
  // Without a vocabulary (null) places are not recognised: a lost camera is looked for at the
  // nearest key frames and at few others in turn, and no loops are closed.
  System(const Camera& camera, const SystemOptions& options, std::shared_ptr<const Vocabulary> vocabulary = nullptr);
  ~System();
  System(const System&) = delete;
  System& operator=(const System&) = delete;

  // Puts a map in place, for example a saved one; an error after the first frame. The camera is looked for in it.
  // `made_by`: the camera it was made with, as it was given then. A map has one camera: what another one made is
  // expressed in the present one (map/camera_change.h). An error when it is in metres and is to be continued by a
  // camera without depth, and when the cameras differ by too much.
  Result<void> set_map(Map map, const Camera& made_by);

  struct Input {
    int64_t frame = 0;                      // rises from frame to frame
    Timestamp stamp = 0;                    // rises too
    ImageView<const uint8_t> image, right;  // right: stereo only
    ImageView<const float> depth;           // RGB-D only, metres
  };
  // Tracks one frame. In localisation only (SystemOptions::localize) every frame is lost as long as there is no map.
  FrameReport process(const Input& input);
  // Relocalisation alone: where one image was taken, from nothing but the image; nothing when its place is not
  // recognised. Waits until key frames asked for are mapped; leaves tracking and mapping as they are.
  std::optional<LocatedImage> locate(const Input& input);
  // Changes between mapping and localisation only (tracker.h), from the next frame on; waits for mapping to end. Error:
  // mapping in a map in metres by a camera without depth.
  Result<std::vector<MappingReport>> set_mode(TrackingMode mode);
  TrackingMode mode() const { return options_.localize ? TrackingMode::localisation : TrackingMode::mapping; }
  // The keypoints of the last frame that show points of the map; none when it has no pose.
  std::vector<TrackedPoint> tracked_points() const;
  // All keypoints of the last frame, then the map points it should have shown and did not; for viewers.
  std::vector<ViewedKeypoint> viewed_keypoints() const;
  // Waits for mapping to end, and locates frames that got no pose where the map reaches them now: backward from where
  // the camera was found (backtrack.h), the others as single images.
  // process() may be called again afterwards.
  std::vector<MappingReport> finish();
  // The warnings of the sensor that came with what finish() or set_mode() returned; process() reports its own. They are
  // logged.
  std::vector<SensorWarning> take_warnings();

  // Gives key frames without colours those of their frames' images (KeyFrameColours::fill()); of rectified pairs the
  // rectified left image. Poses and the rest of the map stay as they are.
  size_t colour_key_frames(const ColourSource& image_of) {
    return colours_.fill(given_.width, given_.height, image_of);
  }

  // The map and the trajectory as they are now. It is made anew only when something changed since the last one, and
  // takes as long as copying all points and working out the poses of all frames.
  std::shared_ptr<const Snapshot> snapshot() const { return snapshots_.get(); }
  // Members of it by themselves. Online: poses as they were given when tracked, of the first submap alone.
  Pinhole camera() const { return snapshots_.camera(); }
  std::vector<SubmapSummary> submaps() const { return snapshot()->submaps; }
  std::vector<PoseOfFrame> trajectory() const { return snapshots_.trajectory(); }
  std::vector<PoseOfFrame> online_trajectory() const;

  struct MapSize {
    size_t key_frames = 0, points = 0;
  };
  MapSize map_size() const;
  // The map as it can be saved.
  MapState map_state() const;
  // The map itself, for tests and tools that look into it.
  const SharedMap& map() const { return map_; }

 private:
  FeaturesPtr extract(const Input& input, int features);
  std::shared_ptr<const KeptDepth> kept_depth(const Input& input, const Features& features) const;
  MappingStatus mapping_status(MappingStatus::Depth depth) const;
  void submit(MapRequest request);
  void apply_visible_mapping(FrameReport& report);
  void apply_all_mapping(FrameReport& report);
  void apply_finished_mapping(FrameReport& report);
  void apply(MappingReport made, FrameReport& report);
  void anchor(const KeyFrameMade& made);
  void anchor_in(const Map& map, const KeyFrameMade& made);
  void record(const Input& input, const Tracker::Outcome& outcome, FrameReport& report);
  void take(Backtracked earlier);
  void discard(uint32_t submap);
  MappingStatus::Depth compare_depth(const Input& input, const FeaturesPtr& features, FrameReport& report);
  void watch_sensor(int64_t frame, FrameReport& report);
  void report_begun_map(FrameReport& report) const;
  void explain_missing_map(TrackResult& result) const;
  bool realtime() const { return options_.schedule() == Schedule::realtime; }

  const Camera given_;
  SystemOptions options_;  // all but `localize` stays as it was given
  const std::shared_ptr<const Vocabulary> vocabulary_;
  SharedMap map_;
  TrajectoryLog log_;
  SnapshotSource snapshots_{map_, log_};
  KeyFrameColours colours_{map_};
  Frontend frontend_;
  Tracker tracker_;
  MappingActor mapping_;
  SensorMonitor monitor_{options_.sensor};
  struct Frames {
    int64_t processed = 0;
    int64_t visible_at = 0;  // the count at which pending mapping becomes visible
    LateFrames late = {};
  };
  Frames frames_;
};

}  // namespace covis
