// SPDX-License-Identifier: Apache-2.0
#include "tests/plugin/small.h"

#include "covis/io/plugin.h"

namespace covis::io {
namespace {

int twice(int value) { return 2 * value; }

}  // namespace

COVIS_PLUGIN(SmallPlugin, twice)

}  // namespace covis::io
