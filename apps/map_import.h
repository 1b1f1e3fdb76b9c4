// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace covis::app {

// Adds `covis map import`, which makes a map of a COLMAP model to localise in.
void add_map_import(CLI::App& map_command, int& exit_code);

}  // namespace covis::app
