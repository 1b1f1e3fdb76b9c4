// SPDX-License-Identifier: Apache-2.0
// How vectors get their room, where doubling would not do.
#pragma once

#include <algorithm>
#include <cstddef>

namespace covis {

// For those filled anew for every frame, whose sizes differ a little. Room for n elements; where it is made, for half
// as many more: the next frame's few more then allocate nothing.
template <class Vector>
void reserve_ahead(Vector& vector, size_t n) {
  if (vector.capacity() < n) vector.reserve(n + n / 2 + 64);
}

// For the very many short ones that a map keeps: doubling would leave a third of their memory unused. Room for one more
// element; where it is made, for a quarter more, and what is left of the allocator's block: they hold 24, 40, 56 …
// bytes.
template <class Vector>
void reserve_one_more(Vector& vector) {
  if (vector.size() < vector.capacity()) return;
  constexpr size_t kItem = sizeof(typename Vector::value_type);
  const size_t bytes = std::max<size_t>(24, (vector.size() + 1 + vector.size() / 4) * kItem);
  vector.reserve(((bytes + 7) / 16 * 16 + 8) / kItem);
}

}  // namespace covis
