// SPDX-License-Identifier: Apache-2.0
// Where frames are once the key frames around them moved with another camera (map/key_frame_moves.h). Each of these
// would carry a frame to another place, as the way between them is another one now.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "covis/map/key_frame_moves.h"
#include "covis/map/relative_pose.h"

namespace covis {

class FramesBetween {
 public:
  // `own`: key frames of the recording that the frames are of, whose numbers say in which order they came.
  FramesBetween(const std::vector<KeyFrameMove>& moves, std::vector<KeyFrameMove> own);

  // The pose of a frame that was given relative to a key frame before the moves. It is carried by the last key frame
  // before it, the next one after it and its reference: those that it was nearer to, by way and turn, count more.
  // Nothing: the reference has not moved.
  std::optional<RelativePose> carried(const Map& map, int64_t frame, const RelativePose& pose) const;

 private:
  std::unordered_map<KeyFrameId, KeyFrameMove> of_;
  std::vector<KeyFrameMove> own_;  // by rising frames
};

}  // namespace covis
