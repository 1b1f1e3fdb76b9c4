// SPDX-License-Identifier: Apache-2.0
// The one check of stamps, wherever they come from: lists, names, messages, trajectories, a program.
#pragma once

#include "covis/core/time.h"

namespace covis {

// Stamps between these bounds can be subtracted from each other: 146 years before and after the epoch.
inline constexpr Timestamp kStampBound = Timestamp{1} << 62;

constexpr bool is_usable_stamp(Timestamp stamp) { return stamp > -kStampBound && stamp < kStampBound; }

}  // namespace covis
