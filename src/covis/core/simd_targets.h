// SPDX-License-Identifier: Apache-2.0
// The instruction set that kernels run with. A kernel exists for every instruction set that Highway supports on this
// machine, chosen at run time, and as a scalar twin with bit-identical results; the tests compare them all.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace covis {

// Returns the instruction sets that this machine and this build support, best first, by their Highway names in lower
// case, and last "scalar", the scalar twins. All give the same results.
std::vector<std::string> simd_targets();
// Selects one of them for all later calls; "best" restores the default. Returns false when there is none of that name.
// Not thread-safe.
bool use_simd_target(std::string_view name);
bool simd_enabled();  // false: the scalar twins are selected

}  // namespace covis
