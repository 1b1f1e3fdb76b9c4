// SPDX-License-Identifier: Apache-2.0
// The rows in which the viewer's page receives a map and a run. They are sent as they lie in memory: little-endian, all
// padding named. web/src/protocol.js reads the same layout.
//
// Metres; poses are camera to world, a quaternion is x, y, z, w. An id of a key frame is KeyFrame::serial; an id of a
// point is its slot, which another point may get after it was removed.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "covis/geometry/se3.h"

namespace covis::view {

static_assert(std::endian::native == std::endian::little, "rows are sent as they lie in memory");

inline constexpr uint32_t kNone = 0xffffffffu;

struct PoseRow {
  std::array<float, 3> t{};
  std::array<float, 4> q{0, 0, 0, 1};
  friend bool operator==(const PoseRow&, const PoseRow&) = default;
};
PoseRow row_of(const SE3& T_wc);

struct KeyFrameRow {
  uint32_t id = 0;
  uint32_t submap = 0;
  int32_t frame = 0;
  uint32_t parent = kNone;  // id of the key frame above it in the spanning tree; kNone: a root
  double stamp = 0;         // seconds
  PoseRow pose;
  uint32_t camera = 0;  // that made it: 0: the one in the info; else one more than its index in the list of cameras
  friend bool operator==(const KeyFrameRow&, const KeyFrameRow&) = default;
};
static_assert(sizeof(KeyFrameRow) == 56);

// A camera other than the one in the info, which made key frames of the same map.
struct CameraRow {
  float fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  uint32_t width = 0, height = 0;        // pixels
  friend bool operator==(const CameraRow&, const CameraRow&) = default;
};
static_assert(sizeof(CameraRow) == 24);

struct PointRow {
  uint32_t id = 0;
  std::array<float, 3> position{};
  std::array<uint8_t, 3> colour{};  // red, green, blue
  uint8_t has_colour = 0;           // 0: the colour is not known
  uint32_t submap = 0;
  int32_t frame = 0;  // the first frame of a key frame that observes it
  friend bool operator==(const PointRow&, const PointRow&) = default;
};
static_assert(sizeof(PointRow) == 28);

// An edge of the covisibility graph, or one that a loop made; a < b.
struct EdgeRow {
  uint32_t a = 0, b = 0;  // ids of key frames
  uint16_t shared = 0;    // points that both observe
  uint16_t loop = 0;      // 1: a loop was closed between them
  friend bool operator==(const EdgeRow&, const EdgeRow&) = default;
};
static_assert(sizeof(EdgeRow) == 12);

// The pose of a frame with every correction so far.
struct PathRow {
  int32_t frame = 0;
  uint32_t submap = 0;
  PoseRow pose;
  friend bool operator==(const PathRow&, const PathRow&) = default;
};
static_assert(sizeof(PathRow) == 36);

// Pixels are counted in quarters, so that sixteen bits suffice.
inline constexpr float kPixelUnits = 4;

struct ObservationRow {
  uint32_t other = 0;  // id of the point, for a key frame's list; id of the key frame, for a point's
  uint16_t u = 0, v = 0;
  friend bool operator==(const ObservationRow&, const ObservationRow&) = default;
};
static_assert(sizeof(ObservationRow) == 8);

enum class KeypointKind : uint32_t {
  tracked,    // shows a map point
  unmatched,  // shows none: new
  lost,       // a map point expected here that was not found
};

struct KeypointRow {
  uint16_t u = 0, v = 0;
  KeypointKind kind = KeypointKind::tracked;
};
static_assert(sizeof(KeypointRow) == 8);

// The result of one frame, as it was when the frame was tracked.
struct FrameRow {
  static constexpr uint8_t kKeyFrame = 1, kTentative = 2, kHasPose = 4;

  int32_t frame = 0;
  uint8_t state = 0;  // index into the names of states (Info)
  uint8_t flags = 0;
  uint16_t reason = 0;  // index into the run's texts; 0: none
  double stamp = 0;     // seconds
  PoseRow pose;         // meaningful with kHasPose
  uint32_t submap = 0;
  int32_t inliers = 0, features = 0;
  float tracking_ms = 0;
  float total_ms = 0;  // with waiting for mapping
  friend bool operator==(const FrameRow&, const FrameRow&) = default;
};
static_assert(sizeof(FrameRow) == 64);

// The position of a key frame's camera.
struct PlaceRow {
  uint32_t id = 0;
  std::array<float, 3> position{};
  uint32_t submap = 0;
  friend bool operator==(const PlaceRow&, const PlaceRow&) = default;
};
static_assert(sizeof(PlaceRow) == 20);

// A loop that was closed, or two submaps that were joined, with the key frames' path before and after.
struct LoopPaths {
  enum class Kind : uint32_t { closed, joined };
  int64_t frame = 0;  // frame of the key frame that saw the place again
  Kind kind = Kind::closed;
  float correction = 0;  // by which that key frame moved, metres
  std::vector<PlaceRow> before, after;
};

}  // namespace covis::view
