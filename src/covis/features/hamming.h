// SPDX-License-Identifier: Apache-2.0
// Hamming distances from one descriptor to many.
#pragma once

#include <cstdint>

#include "covis/features/features.h"

namespace covis {

// Sets out[j] = hamming(a, b[j]) for j in [0, n).
void hamming_row(const Descriptor& a, const Descriptor* b, int n, uint16_t* out);

}  // namespace covis
