// SPDX-License-Identifier: Apache-2.0
#include "covis/core/simd_targets.h"

#include <hwy/targets.h>

#include <cctype>
#include <cstdint>

namespace covis {
namespace {

bool enabled = true;

// Sorted best first: Highway gives better targets lower numbers.
template <class Visit>
void for_each_target(Visit&& visit) {
  hwy::SetSupportedTargetsForTest(0);
  for (int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1) {
    const int64_t target = rest & -rest;
    std::string name = hwy::TargetName(target);
    for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    visit(name, target);
  }
}

}  // namespace

bool simd_enabled() { return enabled; }

std::vector<std::string> simd_targets() {
  std::vector<std::string> names;
  for_each_target([&](const std::string& name, int64_t) { names.push_back(name); });
  names.emplace_back("scalar");
  return names;
}

bool use_simd_target(std::string_view name) {
  enabled = name != "scalar";
  int64_t chosen = 0;  // 0: all targets
  bool known = name == "best" || name == "scalar";
  for_each_target([&](const std::string& target, int64_t bit) {
    if (target != name) return;
    chosen = bit;
    known = true;
  });
  hwy::SetSupportedTargetsForTest(chosen);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  return known;
}

}  // namespace covis
