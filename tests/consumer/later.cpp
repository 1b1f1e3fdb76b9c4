// SPDX-License-Identifier: Apache-2.0
// Makes a later build of libcovis of this one: a function more, and a word when it is loaded.
#include <cstdio>

#include "covis/export.h"

namespace covis {
COVIS_API int added_later();
int added_later() { return 1; }

namespace {
[[maybe_unused]] const int said = std::puts("a later build of libcovis");
}  // namespace
}  // namespace covis
