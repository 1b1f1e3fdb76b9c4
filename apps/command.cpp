// SPDX-License-Identifier: Apache-2.0
// Each subcommand registers itself (cmd_*.cpp) and only parses, calls and prints.
#include "command.h"

#include <spdlog/cfg/env.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/run/activity.h"
#include "commands.h"
#include "covis/core/failure_reason.h"
#include "covis/core/fields.h"
#include "covis/core/log.h"
#include "covis/core/message_text.h"
#include "covis/io/video_file.h"
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
    logger->log(kLevels[static_cast<int>(level)], covis::shown(message));
  });
}

// CLI11 alone would not name an unknown command. Returns the message about it.
std::optional<std::string> unknown_command(const CLI::App& app, int argc, char** argv) {
  const CLI::App* at = &app;
  std::string so_far = "covis";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    std::vector<std::string> names;
    for (const CLI::App* command : at->get_subcommands(nullptr)) {
      if (!command->get_name().empty()) names.push_back(command->get_name());  // a group of options has no name
    }
    if (names.empty() || word.starts_with('-')) return std::nullopt;
    if (std::find(names.begin(), names.end(), word) == names.end())
      return word + ": no such command; did you mean " + so_far + " " + covis::nearest_name(word, names) + "?";
    at = at->get_subcommand(word);
    so_far += " " + word;
  }
  return std::nullopt;
}

// An option with an empty value would count as one that is not given: `--camera "$FORGOTTEN"`.
void refuse_empty_values(CLI::App& app) {
  const CLI::Validator given([](std::string& text) { return std::string(text.empty() ? "its value is empty" : ""); },
                             "");
  for (CLI::Option* option : app.get_options()) {
    if (option->get_items_expected_max() > 0) option->check(given);
  }
  for (CLI::App* command : app.get_subcommands(nullptr)) refuse_empty_values(*command);
}

// Writes help to stdout and errors to stderr. Returns the exit code.
int say(const CLI::App& app, const CLI::ParseError& error) {
  std::ostringstream out, wrong;
  const int code = app.exit(error, out, wrong);
  std::fputs(out.str().c_str(), stdout);
  std::fputs(covis::shown_lines(wrong.str()).c_str(), stderr);
  return code == 0 ? 0 : 2;
}

}  // namespace

int covis_command(int argc, char** argv) {
  covis::app::set_activity(argc, argv);
  covis::app::end_in_order_on_terminate();
  connect_log();
  std::signal(SIGXFSZ, SIG_IGN);              // a limit on the size of files is an error of writing, as a full disk is
  std::signal(SIGPIPE, SIG_IGN);              // who reads stdout or stderr may leave: what a run has made is written
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);  // Covis alone reports a video that it can't read
  covis::io::limit_ffmpeg();
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
      "wrong usage; 130 and 143 `run` ended by Ctrl-C and by SIGTERM (a live camera: 0), what was made until then is "
      "written.");
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
  refuse_empty_values(app);
  if (const auto problem = unknown_command(app, argc, argv)) {
    std::fprintf(stderr, "%s\nRun with --help for more information.\n", covis::shown(*problem).c_str());
    return 2;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    exit_code = say(app, error);
  } catch (const std::exception& error) {
    covis::log(covis::LogLevel::error, covis::app::current_activity() + ": " + std::string(covis::reason_of(error)));
    return 1;
  }
  // Results that could not be written (a full disk, a closed pipe) are a failure.
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) {
    covis::log(covis::LogLevel::error, std::string("stdout: it can't be written: ") + std::strerror(errno));
    return exit_code != 0 ? exit_code : 1;
  }
  return exit_code;
}
