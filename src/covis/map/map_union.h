// SPDX-License-Identifier: Apache-2.0
// Several saved maps as one: the submaps of each stand beside those of the others, nothing of them is moved.
#pragma once

#include "covis/core/error.h"
#include "covis/map/map_state.h"

namespace covis {

// Puts the key frames and points of another map behind those of `map`, with serials that go on where those of `map`
// end. The camera stays that of `map`. Fails, and changes nothing, when 32 bits are too few for all of it.
Result<void> append_map(MapState& map, MapState other);

}  // namespace covis
