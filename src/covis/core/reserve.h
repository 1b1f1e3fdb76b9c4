// SPDX-License-Identifier: Apache-2.0
// Vector growth policies for the cases in which doubling the capacity is unsuitable.
#pragma once

#include <algorithm>
#include <cstddef>

namespace covis {

// For vectors that are refilled for every frame with a slightly different size. Reserves room for n elements; when it
// must allocate, for n + n / 2, so that slightly larger following frames do not allocate.
template <class Vector>
void reserve_ahead(Vector& vector, size_t n) {
  if (vector.capacity() < n) vector.reserve(n + n / 2 + 64);
}

// For the very many short vectors that a map keeps, where doubling would leave a third of their memory unused. Makes
// room for one more element; when it must allocate, it adds a quarter and the rest of the allocator's block (blocks
// hold 24, 40, 56 … bytes).
template <class Vector>
void reserve_one_more(Vector& vector) {
  if (vector.size() < vector.capacity()) return;
  constexpr size_t kItem = sizeof(typename Vector::value_type);
  const size_t bytes = std::max<size_t>(24, (vector.size() + 1 + vector.size() / 4) * kItem);
  vector.reserve(((bytes + 7) / 16 * 16 + 8) / kItem);
}

// For vectors with an element for each slot of a store. Returns that of `slot`; makes room for it, and for a few more,
// when it is beyond the end: the elements made are written to, and so take memory. (The capacity still doubles.)
template <class Vector>
auto& at_slot(Vector& vector, size_t slot) {
  if (slot >= vector.size()) vector.resize(slot + 256);
  return vector[slot];
}

}  // namespace covis
