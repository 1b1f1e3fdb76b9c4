// SPDX-License-Identifier: Apache-2.0
// The table of a plug-in for plugin_test.cpp, which installs it under this name.
#pragma once

namespace covis::io {

struct SmallPlugin {
  static constexpr const char *kName = "covis_late", *kPurpose = "doubles numbers";
  int (*twice)(int);
};

}  // namespace covis::io
