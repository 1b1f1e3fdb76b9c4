// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace covis::app {

// Adds `covis map export`, which writes a saved map in the formats of other programs.
void add_map_export(CLI::App& map_command, int& exit_code);

}  // namespace covis::app
