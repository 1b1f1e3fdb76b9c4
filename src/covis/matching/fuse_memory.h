// SPDX-License-Identifier: Apache-2.0
// Searches of points in key frames that found nothing, so that they are not made again where neighbourhoods overlap.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/ids.h"

namespace covis {

// Exact while no key frame and no point is moved, made or refreshed, and for one set of FuseOptions. Joining accepts
// that some points are refreshed in between (docs/notes/032-merging-maps.md). Forgets everything when it has grown to
// 64 MB: what is forgotten is searched again.
class FuseMemory {
 public:
  bool has(KeyFrameId target, MapPointId point) const;
  void add(KeyFrameId target, MapPointId point);

 private:
  static constexpr size_t kWords = size_t{1} << 23;

  std::vector<std::vector<uint64_t>> words_;  // by slot of the key frame: a bit for each slot of a point
  size_t size_ = 0;                           // sum of their sizes, words
};

}  // namespace covis
