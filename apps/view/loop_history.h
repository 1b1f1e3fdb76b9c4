// SPDX-License-Identifier: Apache-2.0
// Keeps the key frames' path just before and just after each loop, so that both can be shown. It looks at the map
// whenever mapping reports: positions are all it copies.
#pragma once

#include <cstdint>
#include <vector>

#include "apps/view/rows.h"
#include "covis/map/shared_map.h"
#include "covis/slam/messages.h"

namespace covis::view {

class LoopHistory {
 public:
  enum class Change { none, loops };
  // reports: what mapping reported since the last call. Call it after every frame; without reports it does nothing.
  Change look(const SharedMap& map, const std::vector<MappingReport>& reports);
  const std::vector<LoopPaths>& loops() const { return loops_; }

 private:
  std::vector<PlaceRow> now_;     // key frames at the last look
  std::vector<PlaceRow> before_;  // as they were before the whole map moved; until a loop's report takes them
  uint64_t moves_ = 0;            // Map::moves() at the last look
  std::vector<LoopPaths> loops_;
};

}  // namespace covis::view
