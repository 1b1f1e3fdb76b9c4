// SPDX-License-Identifier: Apache-2.0
// Shared by the commands: names of settings, which frames to read, errors, Ctrl-C.
#pragma once

#include <atomic>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/geometry/camera.h"
#include "covis/io/sequence.h"

namespace CLI {
class App;
}

namespace covis::app {

extern const std::map<std::string, Sensor> kSensors;
extern const std::map<std::string, io::SequenceKind> kKinds;

template <class Value>
std::vector<std::string> keys(const std::map<std::string, Value>& map) {
  std::vector<std::string> names;
  names.reserve(map.size());
  for (const auto& entry : map) names.push_back(entry.first);
  return names;
}

template <class Value>
std::string name_of(const std::map<std::string, Value>& map, Value wanted) {
  for (const auto& [name, value] : map) {
    if (value == wanted) return name;
  }
  return {};
}

// The part of a recording that is read, and the way.
struct Reading {
  std::string sensor, kind, camera;
  int64_t first = 0, count = -1;
  int stride = 1;

  io::SequenceOptions options() const;
};
// --sensor, --kind, --camera, --first, --count and --stride.
void add_reading_options(CLI::App& command, Reading& reading);

nlohmann::json camera_json(const Camera& camera);

// Say what went wrong and return the exit code for it.
int fail_with(const std::string& message);
int fail_with(const Error& error);

// The number of the signal (Ctrl-C or SIGTERM) that asked the command to end well; 0: none did. The handler may run on
// any thread, so a sig_atomic_t would not do.
extern std::atomic<int> interrupted;
static_assert(std::atomic<int>::is_always_lock_free);
// From now on the first signal sets `interrupted`, and the second ends the process.
void end_well_on_signals();

}  // namespace covis::app
