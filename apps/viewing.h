// SPDX-License-Identifier: Apache-2.0
// The viewer as the commands use it: `covis run --view` and `covis view`.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "apps/run/run_observer.h"
#include "apps/view/view_state.h"
#include "covis/core/error.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace covis::app {

inline constexpr const char* kViewPort = "8642";

struct ViewOptions {
  enum class AtEnd { keep_serving, close };
  std::string port;  // empty: no viewer; 0: any that is free
  std::string host = "127.0.0.1";
  AtEnd at_end = AtEnd::keep_serving;  // when the run has ended
};
void add_run_view_options(CLI::App& command, ViewOptions& options);
CLI::Option* add_host_option(CLI::App& command, const char* name, ViewOptions& options);

// Shows a run while it goes on.
class RunViewer {
 public:
  virtual ~RunViewer() = default;
  // Listens, and prints the address. The error says what is wrong with address or port, or that there is no viewer in
  // this build.
  static Result<std::unique_ptr<RunViewer>> start(const ViewOptions& options, const nlohmann::json& info);
  virtual RunObserver* observer() = 0;
  virtual void run_ended(view::ViewState last) = 0;
  // Goes on serving until Ctrl-C.
  virtual void serve() = 0;
};

// Shows a state that doesn't change until Ctrl-C. images: folder with the key frames' images by their ids; may be
// missing.
Result<void> serve_state(const ViewOptions& options, view::ViewState state, const std::string& images);

}  // namespace covis::app
