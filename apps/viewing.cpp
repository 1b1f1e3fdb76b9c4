// SPDX-License-Identifier: Apache-2.0
#include "viewing.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "common.h"
#include "covis/core/log.h"

#ifdef COVIS_VIEWER
#include <chrono>
#include <thread>

#include "apps/view_server/finished_view.h"
#include "apps/view_server/live_view.h"
#include "apps/view_server/server.h"
#endif

namespace covis::app {
namespace {

#ifdef COVIS_VIEWER

Result<std::unique_ptr<view::Server>> listen(const ViewOptions& options, std::shared_ptr<view::ViewSource> source) {
  auto server = view::Server::start({.host = options.host, .port = static_cast<uint16_t>(std::stoi(options.port))},
                                    std::move(source));
  if (!server) return server;
  log(LogLevel::info, "viewer: open " + (*server)->url() + " in a browser");
  if (!(*server)->local_only())
    log(LogLevel::warning, options.host + ": the viewer can be reached from other machines, without a password");
  return server;
}

// Waits for Ctrl-C.
void wait_for_end() {
  if (interrupted == 0) log(LogLevel::info, "viewer: it serves until Ctrl-C");
  while (interrupted == 0) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

class ServedRun : public RunViewer {
 public:
  ServedRun(std::shared_ptr<view::LiveView> live, std::unique_ptr<view::Server> server)
      : live_(std::move(live)), server_(std::move(server)) {}
  RunObserver* observer() override { return live_.get(); }
  void run_ended(view::ViewState last) override { live_->run_ended(std::move(last)); }
  void serve() override { wait_for_end(); }

 private:
  std::shared_ptr<view::LiveView> live_;
  std::unique_ptr<view::Server> server_;
};

#else

tl::unexpected<Error> no_viewer() {
  return fail("this command was built without the viewer; install npm and build it with -DCOVIS_VIEWER=ON");
}

#endif

}  // namespace

void add_run_view_options(CLI::App& command, ViewOptions& options) {
  const std::string port = kViewPort;
  CLI::Option* view =
      command
          .add_flag("--view{" + port + "}", options.port,
                    "show the run in a browser: --view or --view=PORT (default: " + port + "; 0: any that is free)")
          ->transform(whole_number_from(0, 65535));
  add_host_option(command, "--view-host", options)->needs(view);
  command
      .add_flag_callback(
          "--view-close", [&options] { options.at_end = ViewOptions::AtEnd::close; },
          "end with the run; without this the result is shown until Ctrl-C")
      ->needs(view);
}

CLI::Option* add_host_option(CLI::App& command, const char* name, ViewOptions& options) {
  return command
      .add_option(name, options.host,
                  "address the viewer listens on; 0.0.0.0: others can see it too, without a password")
      ->capture_default_str();
}

#ifdef COVIS_VIEWER

Result<std::unique_ptr<RunViewer>> RunViewer::start(const ViewOptions& options, const nlohmann::json& info) {
  auto live = std::make_shared<view::LiveView>(info.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  auto server = listen(options, live);
  if (!server) return tl::unexpected(server.error());
  return std::make_unique<ServedRun>(std::move(live), std::move(*server));
}

Result<void> serve_state(const ViewOptions& options, view::ViewState state, const std::string& images) {
  const auto server = listen(options, std::make_shared<view::FinishedView>(std::move(state), images));
  if (!server) return tl::unexpected(server.error());
  wait_for_end();
  return {};
}

#else

Result<std::unique_ptr<RunViewer>> RunViewer::start(const ViewOptions&, const nlohmann::json&) { return no_viewer(); }
Result<void> serve_state(const ViewOptions&, view::ViewState, const std::string&) { return no_viewer(); }

#endif

}  // namespace covis::app
