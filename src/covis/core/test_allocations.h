// SPDX-License-Identifier: Apache-2.0
// For tests that count allocations, or have them fail: replaces operator new (plain, aligned and nothrow). Direct calls
// of malloc are not seen. The replacement affects the whole program: include this file once per executable.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>

#include "covis/core/test_allocation_counts.h"

namespace covis {

inline void* count_and_allocate(size_t n, size_t alignment) {
  ++own_allocations;
  ++all_allocations;
  return alignment > alignof(std::max_align_t)
             ? std::aligned_alloc(alignment, (n + alignment - 1) / alignment * alignment)
             : std::malloc(n);
}

inline void* allocate_or_throw(size_t n, size_t alignment) {
  if (memory_is_full && !has_memory_left) throw std::bad_alloc();
  if (own_failure_in > 0 && --own_failure_in == 0) throw std::bad_alloc();
  if (void* p = count_and_allocate(n, alignment)) return p;
  throw std::bad_alloc();
}

}  // namespace covis

#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
void* operator new(size_t n) { return covis::allocate_or_throw(n, 0); }
void* operator new(size_t n, std::align_val_t a) { return covis::allocate_or_throw(n, static_cast<size_t>(a)); }
void* operator new(size_t n, const std::nothrow_t&) noexcept { return covis::count_and_allocate(n, 0); }
void* operator new(size_t n, std::align_val_t a, const std::nothrow_t&) noexcept {
  return covis::count_and_allocate(n, static_cast<size_t>(a));
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, size_t, std::align_val_t) noexcept { std::free(p); }
