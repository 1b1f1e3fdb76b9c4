// SPDX-License-Identifier: Apache-2.0
// Plug-ins: what brings many libraries and few programs need (videos, bags of ROS 1, compressed images) is in shared
// libraries of its own, which are opened when they are first used. A plug-in lies beside the program or library that
// contains this code, or where it is installed with the command, and shares nothing with it but a table of functions;
// it must link no other part of Covis, whose state (the log, say) would be there twice. Tables change from version to
// version, so a plug-in says which one it is of.
#pragma once

#include <atomic>

#include "covis/core/error.h"

namespace covis::io {

// Returns the table of the plug-in NAME.so, which `purpose` ("reads videos"). The error says both, why it can't be
// opened, and whence it comes; a plug-in of another version is refused.
Result<const void*> open_plugin(const char* name, const char* purpose);

// The table of functions by which a plug-in is used. Each has a name and a purpose, and the source plugin_NAME.cpp,
// which ends with COVIS_PLUGIN. The first call that finds the plug-in opens it; it stays open. One that is installed
// while the program runs is found by the next call.
template <class Table>
Result<const Table*> plugin() {
  static std::atomic<const Table*> opened = nullptr;
  if (const Table* table = opened) return table;
  const auto found = open_plugin(Table::kName, Table::kPurpose);
  if (!found) return tl::unexpected(found.error());
  return opened = static_cast<const Table*>(*found);
}

}  // namespace covis::io

// Defines what a plug-in shows: its version, by which the build compiles it, and its table, of the functions that are
// named. Stands in namespace covis::io.
#define COVIS_PLUGIN(Table, ...)                                                                                \
  extern "C" [[gnu::visibility("default")]] const char* covis_plugin_version() { return COVIS_PLUGIN_VERSION; } \
  extern "C" [[gnu::visibility("default")]] const void* covis_plugin_table() {                                  \
    static constexpr Table table{__VA_ARGS__};                                                                  \
    return &table;                                                                                              \
  }
