// SPDX-License-Identifier: Apache-2.0
// covis map prune and covis map split: a smaller map, and each submap as a file of its own.
#pragma once

namespace CLI {
class App;
}

namespace covis::app {

void add_map_prune(CLI::App& map_command, int& exit_code);
void add_map_split(CLI::App& map_command, int& exit_code);

}  // namespace covis::app
