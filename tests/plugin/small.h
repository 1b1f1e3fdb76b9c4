// SPDX-License-Identifier: Apache-2.0
// The table of a plug-in for plugin_test.cpp, which opens it under the names of its files.
#pragma once

namespace covis::io {

struct SmallPlugin {
  int (*twice)(int);
};

}  // namespace covis::io
