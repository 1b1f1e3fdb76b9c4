// SPDX-License-Identifier: Apache-2.0
// For tests in programs one file of which includes test_allocations.h: what it counts.
#pragma once

#include <atomic>

namespace covis {

inline thread_local long own_allocations = 0;    // allocations of this thread
inline std::atomic<long> all_allocations{0};     // allocations of all threads
inline std::atomic<bool> memory_is_full{false};  // allocations of other threads than those with memory left fail then
inline thread_local bool has_memory_left = false;
inline thread_local long own_failure_in = 0;  // this allocation of the thread fails, counted from 1; 0: none

}  // namespace covis
