// SPDX-License-Identifier: Apache-2.0
// covis view: shows a saved map or the results of a run in a browser.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <utility>

#include "apps/view/open_view.h"
#include "commands.h"
#include "common.h"
#include "covis/exchange/kept_images.h"
#include "viewing.h"

namespace covis::app {
namespace {

struct ViewArguments {
  std::string path;
  ViewOptions view;
};

int run_view(ViewArguments& arguments) {
  auto state = view::open_view(arguments.path);
  if (!state) return fail_with(state.error());
  end_well_on_signals();
  const auto served = serve_state(arguments.view, std::move(*state), exchange::image_folder(arguments.path).string());
  return served ? 0 : fail_with("view: " + served.error().message);
}

}  // namespace
}  // namespace covis::app

void add_view_command(CLI::App& app, int& exit_code) {
  using namespace covis::app;
  auto arguments = std::make_shared<ViewArguments>();
  arguments->view.port = kViewPort;
  CLI::App* command = app.add_subcommand("view", "Show a saved map or the results of a run in a browser");
  command->add_option("PATH", arguments->path, "folder of results (covis run --out), or a saved map")->required();
  command->add_option("--port", arguments->view.port, "port the viewer listens on; 0: any that is free")
      ->capture_default_str()
      ->transform(whole_number_from(0, 65535));
  add_host_option(*command, "--host", arguments->view);
  command->footer(
      "Examples:\n  covis view result\n  covis view office.m --port 0\nIt serves until Ctrl-C (docs/viewer.md). Exit "
      "code "
      "1 when there is nothing to show, or the port is taken.");
  command->callback([arguments, &exit_code] { exit_code = run_view(*arguments); });
}
