// SPDX-License-Identifier: Apache-2.0
// The section of a map file with the colours of its features (docs/map-format.md, section 7). Files of versions before
// 1.3, and those of grey images, have none.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "covis/map/map_state.h"

namespace covis::storage {

inline constexpr uint32_t kColours = 7;  // id of the section

bool has_colours(const MapState& map);
std::string colour_bytes(const MapState& map);
// Gives key frames, whose points are read already, their colours. Returns what is wrong with the bytes, or nothing.
std::string take_colours(std::string_view bytes, std::vector<KeyFrameState>& key_frames);

}  // namespace covis::storage
