// SPDX-License-Identifier: Apache-2.0
// Covis: visual SLAM for monocular, stereo and RGB-D cameras. The public interface: plain values in and out, so that
// nothing of how the library was compiled (Eigen, SIMD) reaches the program that uses it.
//
//   auto slam = covis::Slam::create({
//       .sensor = covis::SensorType::rgbd,
//       .camera = {.width = 640, .height = 480, .fx = 525, .fy = 525, .cx = 320, .cy = 240},
//       .timing = covis::Timing::realtime,
//   });
//   if (!slam) return report(slam.error());
//   auto result = (*slam)->track({.stamp = stamp_ns, .image = {grey, 640, 480, 640}, .depth = {depth, 640, 480, 640}});
//   if (!result) return report(result.error());
//   if (result->tracked()) use(result->pose);
//
// The world of a pose is the camera of its submap's first key frame. Monocular maps have no metric scale: the median
// depth of the points in the first key frame is about 1.
//
// A camera lost for long begins a submap with a world of its own beside the old one. When it sees a place of the old
// one again, the two are joined under the older id, and the other id is never used again. Ids of submaps count from
// 0; poses and points of different submaps can't be compared.
//
// Threads: one thread, the tracking thread, calls everything that is not const, and destroys the object. Any thread may
// call the const members at any time until then, also while the tracking thread is in a call. Two calls may give values
// of different moments.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "covis/export.h"
#include "covis/log.h"
#include "covis/settings.h"
#include "covis/snapshot.h"
#include "covis/types.h"
#include "covis/version.h"

namespace covis {

enum class Timing {
  // For a live camera: what mapping makes shows as soon as it is ready, and a waiting key frame interrupts it. Results
  // depend on the load of the machine.
  realtime,
  // For recordings: results depend on the input and the settings alone; track() waits for mapping where it must.
  deterministic,
};

enum class Mode {
  mapping,
  localisation,  // the map is not changed: no key frames, no points
};

struct SlamOptions {
  SensorType sensor = SensorType::monocular;
  CameraParameters camera = {};           // the left one of a stereo pair
  std::optional<RightCamera> right = {};  // of a stereo pair that is not rectified
  Timing timing = Timing::realtime;
  Mode mode = Mode::mapping;  // localisation needs a map
  std::string map = {};       // file of a saved map to continue or to localise in; empty: a new one is made
  // The file to recognise places by (share/covis/default.covis-voc of the installation); empty: places are not
  // recognised. Then loops stay open, and a lost camera is looked for near its last place and at a few other key frames
  // in turn.
  std::string vocabulary = {};
  // Names and values, for example {"orb.features", "2000"}; default_settings() lists them. system.realtime and
  // system.localize are not for here: timing and mode say it.
  std::vector<std::pair<std::string, std::string>> settings = {};
};

// Something that happened. Key frames that are culled are not reported: a snapshot has those that are left.
struct Event {
  enum class Kind {
    key_frame_made,
    loop_closed,       // a place was seen again, and the map was corrected
    submaps_joined,    // a place of another submap was seen; both are one now
    submap_begun,      // the first map, or one beside those there are
    submap_discarded,  // a monocular submap that was lost in its first moments
    lost,              // the frame has no pose, and the one before had one
    found,             // the camera was lost, and its place in the map is known again
    sensor_doubted,    // images, a pair or depth are not to be believed; a message to the log sink says why
  };
  Kind kind = Kind::key_frame_made;
  int64_t stamp = 0;                       // of the frame or key frame that it happened with, nanoseconds
  int submap = 0;                          // id; of two joined the one that remains; lost: where the camera was
  std::optional<int> ended = {};           // submaps_joined: id of the other
  std::optional<uint64_t> key_frame = {};  // key_frame_made, loop_closed, submaps_joined: MapSnapshot::KeyFrame::id
  std::optional<uint64_t> place = {};  // loop_closed, submaps_joined: the key frame of the place that was seen again
  NoPoseReason reason = NoPoseReason::none;  // lost
};
// Returns the kind's name as it is spelled above.
COVIS_API const char* name(Event::Kind kind);

// Failures are errors of an `expected`. The only exceptions are std::bad_alloc, from tracked_points(), on_event(),
// snapshot(), trajectory(), settings() and default_settings(), and those of the handler of events.
class COVIS_API Slam {
 public:
  // Errors: an impossible camera, an unknown setting, a value out of range, a file that can't be read, a map that does
  // not fit (other features; made without depth, for a camera with depth; made with depth, to be continued by a camera
  // without), localisation without a map.
  static tl::expected<std::unique_ptr<Slam>, std::string> create(const SlamOptions& options);
  ~Slam();
  Slam(const Slam&) = delete;
  Slam& operator=(const Slam&) = delete;

  // ---- From the tracking thread ----

  // Tracks one frame; stamps must rise, for tracking predicts motion from them. Errors: a stamp that does not rise or
  // is 2^62 ns or more from 0 (the year 2116), an image of another size than the camera's, images that do not fit the
  // sensor. An error changes nothing: the next frame is tracked as if there had been no call. But for a lack of memory
  // or threads, which is an error that begins with the call's name: after it track(), locate(), set_mode() and finish()
  // (in the log) go on failing. snapshot(), trajectory() and save_map() then give what there was; reset() and
  // load_map() begin anew.
  tl::expected<FrameResult, std::string> track(const Frame& frame);
  // The keypoints of the last frame that show points of the map; none when it has no pose.
  std::vector<TrackedPoint> tracked_points();

  // The pose of one image in the present map, from nothing but the image (the stamp is not read); no pose when its
  // place is not recognised. Leaves tracking and mapping as they are; waits until the key frames asked for are mapped.
  // Without a vocabulary it tries the five oldest key frames only. Errors as above.
  tl::expected<std::optional<Location>, std::string> locate(const Frame& frame);

  // Changes between mapping and localisation only, from the next frame on, after finish(). When mapping begins from a
  // pose that dead reckoning carried, the camera is to be found in the map first. Errors: localisation without a map;
  // mapping in a map in metres by a camera without depth.
  tl::expected<void, std::string> set_mode(Mode mode);

  // Waits until everything asked of mapping is done, and locates frames that got no pose where the map reaches them
  // now; frames may be tracked afterwards.
  void finish();
  // Forgets the map and the trajectory; mapping begins anew with the next frame, whose stamp may be any. Where memory
  // or threads do not suffice for that, it says so in the log, and track() and the others fail until it is done again.
  void reset();
  // Puts a saved map in place of the present one, as reset() does, to be continued or, in localisation only, to
  // localise in. The camera is looked for in it. Errors as those of create(); then nothing has changed.
  tl::expected<void, std::string> load_map(const std::string& file);

  // Calls `handler` for each event, in their order, from inside track(), set_mode() and finish(), after the work and
  // before the result is returned. It may call the const members and on_event(), which
  // holds from the next event on. An exception that it throws comes out of the call; the work has been done, and the
  // events after it are lost. An empty handler ends it.
  void on_event(std::function<void(const Event&)> handler);

  // ---- From any thread, at any time ----

  Mode mode() const;
  // The map and the trajectory as they are now. It is made anew only when something changed since the last one. Mapping
  // waits while the map is copied, tracking while the list of frames is.
  std::shared_ptr<const MapSnapshot> snapshot() const;
  // MapSnapshot::trajectory by itself, without the copy of the map.
  std::vector<TrajectoryPose> trajectory() const;
  // Saves the map to one file, from which it can be loaded by create(), load_map() and `covis run --map`. At any moment
  // the file is either the complete old or the complete new one. Call finish() before to have all of it. Error: what
  // stands there is neither a map nor empty, and is not replaced.
  tl::expected<void, std::string> save_map(const std::string& file) const;
  // The camera in use: fx, fy, distortion, readout, the noise of depth and its camera as they were estimated so far,
  // the rest as given; of a pair that is rectified here the rectified camera. The focal length of a monocular or
  // RGB-D camera is refined, by 5 % at most, where the map tells it surely; {"mapper.refine_focal", "false"} keeps
  // the one given. For a monocular camera given without distortion the first two radial coefficients are looked for,
  // and given here as Brown's model ({"mapper.refine_distortion", "false"}: not). The readout is looked for where it
  // was given as 0 ({"tracker.readout", "0"}: not).
  // Where the depth images of an RGB-D camera are not registered to the images, and depth_fx was given as 0, the camera
  // of depth is found, given here and saved with maps ({"mapper.register_depth", "false"}: not looked for).
  // To continue a saved map give the camera as it was given when it was begun, not this one; only its readout may be
  // given as it was found.
  CameraParameters camera() const;
  // The pose of the rectified left camera in the given left camera's coordinates, a rotation: where pairs are rectified
  // here all poses are the rectified camera's. Without a `right` camera the identity.
  Pose rectified_left() const;
  // The settings in use.
  std::vector<Setting> settings() const;

 private:
  struct COVIS_HIDDEN Impl;
  COVIS_HIDDEN explicit Slam(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace covis
