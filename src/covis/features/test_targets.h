// SPDX-License-Identifier: Apache-2.0
// For tests: the same by every instruction set.
#pragma once

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstdint>

#include "covis/features/simd.h"

namespace covis {

// Runs `check` with every instruction set this machine and this build have.
template <class Check>
void for_each_target(Check&& check) {
  const int64_t all = hwy::SupportedTargets() & HWY_TARGETS;
  for (int64_t rest = all; rest != 0; rest &= rest - 1) {
    const int64_t target = rest & -rest;
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    check();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace covis
