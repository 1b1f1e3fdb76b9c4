// SPDX-License-Identifier: Apache-2.0
// The plain values of the public interface: cameras, images, frames, poses, states and reasons.
//
// Conventions: metres, radians, nanoseconds; camera x right, y down, z forward; a Pose is T_wc, camera to world. Enums
// may get values at their end in later versions; structs keep their members within a minor version.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "covis/export.h"

namespace covis {

enum class SensorType { monocular, stereo, rgbd };
enum class LensType { none, brown_conrady, kannala_brandt };

struct CameraParameters {
  int width = 0, height = 0;              // pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  double baseline = 0;                    // metres between the cameras of a rectified stereo pair; not asked for RGB-D
  // The noise of a depth z, RGB-D: sigma = a + b z^2 (metres, 1 / metres). Both 0: it is estimated from the map.
  double depth_sigma_a = 0, depth_sigma_b = 0;
  LensType lens = LensType::none;          // a stereo pair has one only when it is rectified here (RightCamera)
  double distortion[5] = {0, 0, 0, 0, 0};  // brown_conrady: k1 k2 p1 p2 k3; kannala_brandt: k1 k2 k3 k4
  // Rolling shutter: seconds from the exposure of the image's first row to that of the last, from -0.2 to 0.2; negative
  // where the last row comes first. 0: all rows are exposed at once, or it is not known, and a run may find one. The
  // setting tracker.readout goes before it.
  double readout = 0;
  // The camera of depth images that are not registered to the other images, RGB-D: focal length and principal point in
  // pixels, and where it is, metres to the right of the other camera and below it. depth_fx 0: they are registered, or
  // a run may find how they are to be. depth_cx, depth_cy 0: as cx and cy.
  double depth_fx = 0, depth_cx = 0, depth_cy = 0;
  double depth_x = 0, depth_y = 0;
};

struct Pose {
  double x = 0, y = 0, z = 0;             // metres
  double qx = 0, qy = 0, qz = 0, qw = 1;  // unit quaternion
};

// The right camera of a stereo pair that is not rectified. The images are rectified when they come.
struct RightCamera {
  CameraParameters camera = {};  // without baseline; readout: 0, or that of the left camera
  Pose pose = {};                // T_left_right: the right camera's pose in the left one's coordinates
};

// An image that stays the caller's; it is read during the call only. stride: elements from a row to the next.
struct GreyImage {
  const uint8_t* data = nullptr;
  int width = 0, height = 0;
  ptrdiff_t stride = 0;
};
// Metres along z, of the grey image's size; not from 0.001 to 10000 (0, NaN, infinite): no measurement. Best registered
// to the grey image; where it is not, a run finds that out as the map grows.
struct DepthImage {
  const float* data = nullptr;
  int width = 0, height = 0;
  ptrdiff_t stride = 0;
};

// Red, green, blue.
using Colour = std::array<uint8_t, 3>;
inline constexpr Colour kNoColour{128, 128, 128};  // stands for an unknown colour: all images were grey
enum class ColourOrder { rgb, bgr };
// Three bytes a pixel. stride: bytes from a row to the next.
struct ColourImage {
  const uint8_t* data = nullptr;
  int width = 0, height = 0;
  ptrdiff_t stride = 0;
  ColourOrder order = ColourOrder::rgb;
};

// The images of one moment.
struct Frame {
  int64_t stamp = 0;      // nanoseconds
  GreyImage image = {};   // the left one of a stereo pair; empty: it is made of `colour`
  GreyImage right = {};   // stereo only
  DepthImage depth = {};  // RGB-D only
  // The same picture as `image` in colour, from which the map's points get their colours; may be empty. Poses depend on
  // the grey image alone.
  ColourImage colour = {};
};

enum class TrackingState {
  not_initialised,  // there is no map yet
  tracking,         // the frame has a pose
  lost,             // the frame's place in the map is not known
};
// Returns the state's name as it is spelled above.
COVIS_API const char* name(TrackingState state);

// The reason why a frame has no pose.
enum class NoPoseReason {
  none,  // it has one
  // A map is to be begun.
  waiting_for_first_view,
  few_features,                 // for a first view or key frame
  few_features_with_depth,      // for a first key frame
  waiting_for_parallax,         // monocular: the first view is taken, and a second one is to come
  few_matches_with_first_view,  // monocular; begins again with this view
  few_matches_for_two_views,    // monocular
  no_motion_explains_matches,   // monocular
  motion_ambiguous,             // monocular: move sideways
  few_points_of_two_views,      // monocular
  low_parallax,                 // monocular: move sideways
  initial_map_failed,           // its adjustment left too little
  no_map_to_localise_in,
  // The camera is lost.
  few_matches_with_last_frame,
  few_agree_with_last_frame,  // matches that agree on a pose
  no_reference_key_frame,
  few_matches_with_key_frame,
  few_agree_with_key_frame,
  no_rotation_seen,
  few_map_points_agree,
  little_of_view_explained,  // by the pose found
  pose_uncertain,
  place_looks_different,  // things match, but not what stands around them
  no_key_frame_matches,   // of those tried for relocalisation
};
// Returns the reason's name as it is spelled above.
COVIS_API const char* name(NoPoseReason reason);
// Returns the reason in words; empty for `none`.
COVIS_API const char* describe(NoPoseReason reason);

// 6 x 6, row by row: of x, y, z (metres) and of a small turn about the world's x, y, z axes through the camera
// (radians), as in ROS's PoseWithCovariance.
using PoseCovariance = std::array<double, 36>;

// Result of tracking one frame.
struct FrameResult {
  TrackingState state = TrackingState::not_initialised;
  NoPoseReason reason = NoPoseReason::none;  // why there is no pose; none when tracking
  Pose pose;                                 // meaningful when tracking
  int submap = 0;                            // id of the submap whose world the pose is in
  // The camera was found far from its last place, or found again by few matches, less than a second ago. If the frames
  // of that second do not confirm the place, they lose their poses (the trajectory leaves them out), and a later frame
  // is lost or found elsewhere. Also true while images or depth are not to be believed (Event::Kind::sensor_doubted).
  bool tentative = false;
  // In localisation only: the frame shows too few points of the map, and its own depth carried the pose on. It drifts.
  bool dead_reckoned = false;
  int inliers = 0;         // map points that agree with the pose
  bool key_frame = false;  // a key frame was asked for
  // Frames from this stamp on had poses at a place that proved wrong; they have none any more.
  std::optional<int64_t> retracted_from = {};
  // How well this frame's points determine the pose, with the map taken as exact. Nothing for the frame that begins a
  // submap, and where they do not determine it.
  std::optional<PoseCovariance> covariance = {};

  bool tracked() const { return state == TrackingState::tracking; }
};

// A keypoint of a frame that shows a point of the map, as the map was when it was tracked: a snapshot taken later may
// have the point no more. Two keypoints may show one point.
struct TrackedPoint {
  double u = 0, v = 0;         // pixels of the image as it was given (of the rectified one where pairs are rectified)
  uint64_t point = 0;          // id of the point (MapSnapshot::Point)
  double x = 0, y = 0, z = 0;  // the point in the world of the frame's submap, metres
};

// Result of locating one image.
struct Location {
  Pose pose;
  int submap = 0;                                 // id of the submap whose world the pose is in
  int inliers = 0;                                // map points that agree with the pose
  std::optional<PoseCovariance> covariance = {};  // as FrameResult::covariance
};

struct TrajectoryPose {
  int64_t stamp = 0;  // nanoseconds, as given
  Pose pose;
  int submap = 0;  // id of the submap whose world the pose is in
};

}  // namespace covis
