// SPDX-License-Identifier: Apache-2.0
#include "covis/features/hamming.h"

namespace covis {

void hamming_row(const Descriptor& a, const Descriptor* b, int n, uint16_t* out) {
  for (int j = 0; j < n; ++j) out[j] = static_cast<uint16_t>(hamming(a, b[j]));
}

}  // namespace covis
