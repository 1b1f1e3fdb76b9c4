// SPDX-License-Identifier: Apache-2.0
// The subcommands of covis. Each adds itself to the app; when it is called it sets the exit code.
#pragma once

namespace CLI {
class App;
}

void add_run_command(CLI::App& app, int& exit_code);
void add_calibrate_command(CLI::App& app, int& exit_code);
void add_view_command(CLI::App& app, int& exit_code);
void add_eval_command(CLI::App& app, int& exit_code);
void add_check_command(CLI::App& app, int& exit_code);
void add_synth_command(CLI::App& app, int& exit_code);
void add_map_command(CLI::App& app, int& exit_code);
void add_vocab_command(CLI::App& app, int& exit_code);
void add_localize_command(CLI::App& app, int& exit_code);
