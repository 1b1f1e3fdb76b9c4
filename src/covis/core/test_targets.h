// SPDX-License-Identifier: Apache-2.0
// For tests: compares the results of all instruction sets.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "covis/core/simd_targets.h"

namespace covis {

// Runs `check` with every instruction set that this machine and this build support, and with the scalar twins.
template <class Check>
void for_each_target(Check&& check) {
  for (const std::string& target : simd_targets()) {
    SCOPED_TRACE(target);
    ASSERT_TRUE(use_simd_target(target));
    check();
  }
  use_simd_target("best");
}

// Checks that make() returns the same with every target as with the scalar twins.
template <class Make>
void expect_scalar_twin(Make&& make) {
  use_simd_target("scalar");
  const auto expected = make();
  for_each_target([&] { EXPECT_TRUE(make() == expected); });
}

}  // namespace covis
