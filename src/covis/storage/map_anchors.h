// SPDX-License-Identifier: Apache-2.0
// The section of a map file that says with which key frames' patches features were aligned (docs/map-format.md, section
// 11). Files of versions before 1.7, and of maps without patches, have none.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "covis/map/map_state.h"

namespace covis::storage {

inline constexpr uint32_t kAnchors = 11;  // id of the section

bool has_anchors(const MapState& map);
std::string anchor_bytes(const MapState& map);
// Reads Features::anchor of each key frame; `features`: how many it has. Returns what is wrong with the bytes, or
// nothing.
std::string read_anchors(std::string_view bytes, const std::vector<uint32_t>& features, uint32_t next_serial,
                         std::vector<AlignedVector<uint64_t>>& anchors);

}  // namespace covis::storage
