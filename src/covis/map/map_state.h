// SPDX-License-Identifier: Apache-2.0
// A map taken apart into plain lists, for saving and loading: indices in place of handles, and nothing that follows
// from the rest (covisibility, children, the points' observations). Taking it apart is a copy without the features,
// which are shared: short enough to be done under the map's lock; all that is slow comes after, without it.
//
// The order depends on the map alone: key frames by rising serial, points by rising slot. Map::state() of a map put
// together by Map::from_state() is the same state again.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "covis/map/map.h"

namespace covis {

struct KeyFrameState {
  uint32_t serial = 0;
  int64_t frame = 0;
  Timestamp stamp = 0;
  SE3 T_cw;
  FeaturesPtr features;
  std::vector<uint32_t> points;      // for each feature the index of its map point, or MapState::kNone
  uint32_t parent = 0xffffffffu;     // index of a key frame, or MapState::kNone: the root of a submap
  std::vector<uint32_t> loop_edges;  // indices of key frames, rising
  ColoursPtr colours;                // KeyFrame::colours
};

struct MapPointState {
  Eigen::Vector3d position_w = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_w = Eigen::Vector3d::Zero();
  Descriptor descriptor;
  float d_min = 0, d_max = 0;  // metres
  uint32_t reference = 0;      // index of a key frame
  uint32_t visible = 1, found = 1;
};

struct MapState {
  static constexpr uint32_t kNone = 0xffffffffu;

  std::vector<KeyFrameState> key_frames;
  std::vector<MapPointState> points;
  uint32_t root = kNone;  // index of the first key frame without a parent
  uint32_t next_serial = 0;
  Pinhole camera;  // the camera of all key frames
};

// True when a pyramid can be made of these figures: at most 32 levels, a factor from 1 to 4.
bool valid_pyramid(int levels, float factor);

// From 1/64 to 64.
bool valid_pixel_size(float base);

bool valid_camera(const Pinhole& camera);

// The first fault of features, for example after reading them from a file; empty when there is none. The grid is not
// looked at: it is built from arrays that pass here, with these bounds.
std::string problem_of(const Features& features, const ImageBounds& bounds);

// The first index out of range, list of a wrong length or number that makes no sense; empty when there is none. What
// passes can be put together; whether it is a whole map (the tree, the observations) is what Map::check() says.
std::string problem_of(const MapState& state);

}  // namespace covis
