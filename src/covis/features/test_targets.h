// SPDX-License-Identifier: Apache-2.0
// For tests: the same by every instruction set.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "covis/features/simd.h"

namespace covis {

// Runs `check` with every instruction set this machine and this build have, and with the scalar twins.
template <class Check>
void for_each_target(Check&& check) {
  for (const std::string& target : simd_targets()) {
    SCOPED_TRACE(target);
    ASSERT_TRUE(use_simd_target(target));
    check();
  }
  use_simd_target("best");
}

// Every target must return what the scalar twins make.
template <class Make>
void expect_scalar_twin(Make&& make) {
  use_simd_target("scalar");
  const auto expected = make();
  for_each_target([&] { EXPECT_TRUE(make() == expected); });
}

}  // namespace covis
