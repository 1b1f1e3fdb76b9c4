// SPDX-License-Identifier: Apache-2.0
// covis map merge: one map of several recordings.
#pragma once

namespace CLI {
class App;
}

namespace covis::app {

void add_map_merge(CLI::App& map_command, int& exit_code);

}  // namespace covis::app
