// SPDX-License-Identifier: Apache-2.0
// A pose relative to a key frame. Frames are kept so, because the key frame carries every later correction: bundle
// adjustment and loops move it, and what is relative to it moves along (algorithms.md §6).
#pragma once

#include <optional>

#include "covis/map/map.h"

namespace covis {

struct RelativePose {
  KeyFrameId key_frame;  // the reference
  double scale = 1;      // KeyFrame::scale of the reference when T_cr was measured: loops may change lengths after it
  SE3 T_cr;              // from the reference's camera to this one

  // The pose of a camera at T_cw now, relative to a live key frame.
  static RelativePose of(const Map& map, const SE3& T_cw, KeyFrameId key_frame) {
    const KeyFrame& reference = map.at(key_frame);
    return {key_frame, reference.scale, T_cw * reference.T_cw.inverse()};
  }
  // A key frame relative to itself.
  static RelativePose at(const Map& map, KeyFrameId key_frame) { return {key_frame, map.at(key_frame).scale, SE3()}; }

  // The same pose as the map has it now, relative to a key frame that lives: the reference, or the nearest living
  // ancestor of an erased one. Nothing for a key frame that never was.
  std::optional<RelativePose> resolved(const Map& map) const {
    const auto found = map.resolve(key_frame);
    if (!found) return std::nullopt;
    return RelativePose{found->key_frame, map.at(found->key_frame).scale, found->carry(T_cr, scale)};
  }
  // T_cw, of a reference that lives.
  SE3 T_cw(const Map& map) const { return T_cr * map.at(key_frame).T_cw; }
  // The factor by which lengths near the reference have grown since. 1 for a key frame that never was.
  double growth(const Map& map) const {
    const auto found = map.resolve(key_frame);
    return found ? found->scale / scale : 1;
  }
};

// What another rolling shutter of the camera does to a pose: T_cr is moved by so much for each second by which
// Pinhole::row_time differs from the one that the frame was tracked with.
struct ShutterResponse {
  Eigen::Matrix<float, 6, 1> move = Eigen::Matrix<float, 6, 1>::Zero();  // a twist of the camera; zero: not known
  double row_time = 0;                                                   // the frame was tracked with it

  SE3 corrected(const SE3& T_cr, double row_time_now) const {
    if (row_time_now == row_time || move.isZero(0)) return T_cr;
    return SE3::exp((row_time_now - row_time) * move.cast<double>()) * T_cr;
  }
};

}  // namespace covis
