// SPDX-License-Identifier: Apache-2.0
// Vectors that are filled anew for every frame, whose sizes differ a little.
#pragma once

#include <cstddef>

namespace covis {

// Room for n elements; where it is made, for half as many more: the next frame's few more then allocate nothing.
template <class Vector>
void reserve_ahead(Vector& vector, size_t n) {
  if (vector.capacity() < n) vector.reserve(n + n / 2 + 64);
}

}  // namespace covis
