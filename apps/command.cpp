// SPDX-License-Identifier: Apache-2.0
// Each subcommand registers itself (cmd_*.cpp) and only parses, calls and prints.
#include "command.h"

#include <spdlog/cfg/env.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "commands.h"
#include "covis/core/fields.h"
#include "covis/core/log.h"
#include "covis/version.h"
#include "sandbox.h"

namespace {

// The library's messages go to stderr; stdout is reserved for results.
void connect_log() {
  auto logger = spdlog::stderr_color_mt("covis");
  spdlog::cfg::load_env_levels();  // SPDLOG_LEVEL=debug shows everything
  logger->set_pattern("%^%l%$: %v");
  covis::set_log_sink([logger](covis::LogLevel level, std::string_view message) {
    static constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info,
                                                            spdlog::level::warn, spdlog::level::err};
    logger->log(kLevels[static_cast<int>(level)], message);
  });
}

}  // namespace

int covis_command(int argc, char** argv) {
  connect_log();
  CLI::App app{"Covis: visual SLAM for monocular, stereo and RGB-D cameras"};
  app.set_version_flag("--version", std::string("covis ") + covis::version());
  app.require_subcommand(1);
  // Options of the command itself take effect before those of its subcommands, which do the work.
  app.add_option_function<std::vector<std::string>>(
         "--sandbox",
         [](const std::vector<std::string>& folders) {
           if (const auto entered = covis::app::enter_sandbox(folders); !entered)
             throw std::runtime_error(entered.error().message);
         },
         "folder that may be written to, and nothing else: for files from strangers (docs/security.md); may be "
         "repeated, stands before COMMAND")
      ->allow_extra_args(false);
  app.footer(
      "covis COMMAND --help shows details and examples.\nExit codes: 0 done; 1 the input or the result is not right; 2 "
      "wrong usage; 130 `run` ended by Ctrl-C, all its files written.");
  int exit_code = 0;
  add_run_command(app, exit_code);
  add_calibrate_command(app, exit_code);
  add_view_command(app, exit_code);
  add_eval_command(app, exit_code);
  add_check_command(app, exit_code);
  add_synth_command(app, exit_code);
  add_map_command(app, exit_code);
  add_vocab_command(app, exit_code);
  add_localize_command(app, exit_code);
  // CLI11 alone would not name the unknown word.
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands(nullptr)) commands.push_back(command->get_name());
  if (const std::string word = argc > 1 ? argv[1] : "-";
      !word.starts_with('-') && std::find(commands.begin(), commands.end(), word) == commands.end()) {
    std::fprintf(stderr, "%s: no such command; did you mean covis %s?\nRun with --help for more information.\n",
                 word.c_str(), covis::nearest_name(word, commands).c_str());
    return 2;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    covis::log(covis::LogLevel::error, error.what());
    return 1;
  }
  // Results that could not be written (a full disk, a closed pipe) are a failure.
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
    covis::log(covis::LogLevel::error, std::string("stdout: it can't be written: ") + std::strerror(errno));
    return exit_code != 0 ? exit_code : 1;
  }
  return exit_code;
}
