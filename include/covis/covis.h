// SPDX-License-Identifier: Apache-2.0
// Covis: visual SLAM for monocular, stereo and RGB-D cameras. The public interface: plain values in and out, so that
// nothing of how the library was compiled (Eigen, SIMD) reaches the program that uses it.
//
//   auto slam = covis::Slam::create(
//       {.width = 640, .height = 480, .fx = 525, .fy = 525, .cx = 320, .cy = 240, .baseline = 0.08},
//       covis::SensorType::rgbd);
//   if (!slam) return report(slam.error());
//   auto result = (*slam)->track_rgbd(stamp_ns, {grey, 640, 480, 640}, {depth, 640, 480, 640});
//   if (!result) return report(result.error());
//   if (result->tracked) use(result->pose);
//
// Conventions: metres, radians, nanoseconds; camera x right, y down, z forward; a Pose is T_wc, camera to world; the
// world is the camera of the first key frame. Monocular maps have no metric scale: the median depth
// of the points in the first key frame is about 1.
//
// A camera lost for long begins a submap with a world of its own beside the old one. When it sees a place of the old
// one again, the two are joined under the older id, and the other id is never used again. Ids of submaps count from
// 0; poses and points of different submaps can't be compared.
//
// Threads: one thread calls track_*(), locate_*() and finish(), and destroys the object. Any thread may call the const
// members (trajectory(), key_frames(), points(), camera()) at any time until then. Two calls may give values of
// different moments.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "covis/export.h"
#include "covis/version.h"

namespace covis {

enum class SensorType { monocular, stereo, rgbd };
enum class LensType { none, brown_conrady, kannala_brandt };

struct CameraParameters {
  int width = 0, height = 0;              // pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  double baseline = 0;                    // metres between the cameras of a rectified stereo pair; not asked for RGB-D
  // The noise of a depth z, RGB-D: sigma = a + b z^2 (metres, 1 / metres). Both 0: it is estimated from the map.
  double depth_sigma_a = 0, depth_sigma_b = 0;
  LensType lens = LensType::none;          // monocular and RGB-D; stereo pairs come rectified
  double distortion[5] = {0, 0, 0, 0, 0};  // brown_conrady: k1 k2 p1 p2 k3; kannala_brandt: k1 k2 k3 k4
};

struct Pose {
  double x = 0, y = 0, z = 0;             // metres
  double qx = 0, qy = 0, qz = 0, qw = 1;  // unit quaternion
};

// An image that stays the caller's; it is read during the call only. stride: elements from a row to the next.
struct GreyImage {
  const uint8_t* data = nullptr;
  int width = 0, height = 0;
  ptrdiff_t stride = 0;
};
// Metres along z, registered to the grey image; 0 or not finite: no measurement.
struct DepthImage {
  const float* data = nullptr;
  int width = 0, height = 0;
  ptrdiff_t stride = 0;
};

enum class TrackingState {
  not_initialised,  // there is no map yet
  tracking,         // the frame has a pose
  lost,             // the frame's place in the map is not known
};
// Returns the state's name as it is spelled above.
COVIS_API const char* name(TrackingState state);

// Result of tracking one frame.
struct FrameResult {
  TrackingState state = TrackingState::not_initialised;
  bool tracked = false;  // state is tracking
  Pose pose;             // meaningful when tracked
  int submap = 0;        // id of the submap whose world the pose is in
  // The camera was found far from its last place, less than a second ago. If the frames of that second do not confirm
  // the place, they lose their poses (trajectory() leaves them out), and a later frame is lost or found elsewhere.
  bool tentative = false;
  std::string reason;      // why there is no pose; empty when tracked
  int inliers = 0;         // map points that agree with the pose
  bool key_frame = false;  // a key frame was asked for
};

struct StampedPoseResult {
  int64_t stamp = 0;  // nanoseconds, as given
  Pose pose;
  int submap = 0;  // id of the submap whose world the pose is in
};

// Result of locating one image.
struct Location {
  Pose pose;
  int submap = 0;  // id of the submap whose world the pose is in
};

// A point of the map.
struct Point {
  double x = 0, y = 0, z = 0;  // metres
  int submap = 0;              // id of the submap whose world it is in
};

class COVIS_API Slam {
 public:
  // Settings by name, as `covis run --dump-config` lists them, for example {"orb.features", "2000"}. Errors of
  // create(): an impossible camera, an unknown setting, a value out of range, a vocabulary that can't be read, and
  // system.localize, which needs a saved map (only the command loads one: covis run --localize).
  using Settings = std::vector<std::pair<std::string, std::string>>;
  // `vocabulary`: the file to recognise places by (share/covis/default.covis-voc of the installation); empty: places
  // are not recognised. Then loops stay open, and a lost camera is looked for near its last place and at a few other
  // key frames in turn.
  static tl::expected<std::unique_ptr<Slam>, std::string> create(const CameraParameters& camera, SensorType sensor,
                                                                 const Settings& settings = {},
                                                                 const std::string& vocabulary = {});
  ~Slam();
  Slam(const Slam&) = delete;
  Slam& operator=(const Slam&) = delete;

  // Tracks one frame; stamps (nanoseconds) must rise, for tracking predicts motion from them. Errors: a stamp that does
  // not rise, an image of another size than the camera's, a call that does not fit the sensor. An error changes
  // nothing: the next frame is tracked as if there had been no call. From one thread.
  tl::expected<FrameResult, std::string> track_monocular(int64_t stamp, const GreyImage& image);
  tl::expected<FrameResult, std::string> track_stereo(int64_t stamp, const GreyImage& left, const GreyImage& right);
  tl::expected<FrameResult, std::string> track_rgbd(int64_t stamp, const GreyImage& image, const DepthImage& depth);

  // The pose of one image in the present map, from nothing but the image; no pose when its place is not recognised.
  // Leaves tracking and mapping as they are; waits until the key frames asked for are mapped. Needs a vocabulary:
  // without one it tries the five oldest key frames only. Errors as above. From the thread that tracks.
  using Located = tl::expected<std::optional<Location>, std::string>;
  Located locate_monocular(const GreyImage& image);
  Located locate_stereo(const GreyImage& left, const GreyImage& right);
  Located locate_rgbd(const GreyImage& image, const DepthImage& depth);

  // Waits until everything asked of mapping is done, and locates frames that got no pose where the map reaches them
  // now; frames may be tracked afterwards. From the thread that tracks.
  void finish();

  // The four below: from any thread, at any time, while another tracks too.
  // Poses of all tracked frames with every correction so far, without those that were tentative and proved wrong. A
  // frame that got no pose when it was tracked may have one now: it is located from later ones where the map reaches
  // it.
  std::vector<StampedPoseResult> trajectory() const;
  // Poses of the map's key frames with every correction so far, in the order in which they were made.
  std::vector<StampedPoseResult> key_frames() const;
  // All points of the map.
  std::vector<Point> points() const;
  // The camera in use: fx, fy and the noise of depth as they were estimated so far, the rest as given to create(). The
  // focal length of a monocular or RGB-D camera is refined, by 5 % at most, where the map tells it surely;
  // {"mapper.refine_focal", "false"} keeps the one given.
  CameraParameters camera() const;

 private:
  struct Impl;
  explicit Slam(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace covis
