// SPDX-License-Identifier: Apache-2.0
#include "covis/io/plugin.h"

#include <dlfcn.h>
#include <link.h>

#include <filesystem>
#include <string>
#include <string_view>

namespace covis::io {
namespace {

namespace fs = std::filesystem;

// The folder of the program or shared library that this code is linked into.
fs::path own_folder() {
  Dl_info info{};
  void* map = nullptr;
  // A program has no name there.
  if (dladdr1(reinterpret_cast<const void*>(&own_folder), &info, &map, RTLD_DL_LINKMAP) != 0) {
    if (const char* name = static_cast<const link_map*>(map)->l_name; *name != '\0')
      return fs::path(name).parent_path();
  }
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

// Beside the program, as in a folder that was copied and in the Python package; where it is installed, as seen from the
// command and from programs one folder below the build's; and as seen from those in the build's own folder.
fs::path file_of(const char* name) {
  const fs::path folder = own_folder(), installed = (folder / COVIS_PLUGINS_FROM_BIN).lexically_normal();
  const std::string file = std::string(name) + ".so";
  for (const fs::path& place : {folder, installed, folder / COVIS_PLUGINS}) {
    std::error_code error;
    if (fs::exists(place / file, error)) return place / file;
  }
  return installed / file;
}

}  // namespace

Result<const void*> open_plugin(const char* name, const char* purpose) {
  const fs::path file = file_of(name);
  const std::string whence =
      ". It is installed with the command (Debian's package covis) and with the Python package (python3-covis)";
  void* const opened = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!opened) {
    const char* const reason = dlerror();  // it names the file
    return fail(file.filename().string() + ", which " + purpose + ", can't be opened: " + (reason ? reason : "") +
                whence);
  }
  const auto version = reinterpret_cast<const char* (*)()>(dlsym(opened, "covis_plugin_version"));
  const auto table = reinterpret_cast<const void* (*)()>(dlsym(opened, "covis_plugin_table"));
  if (version && table && std::string_view(version()) == COVIS_PLUGIN_VERSION) return table();
  const std::string found = version ? std::string("is of Covis ") + version() : "does not say its version";
  dlclose(opened);
  return fail(file.string() + ", which " + purpose + ", " + found +
              "; the one of Covis " COVIS_PLUGIN_VERSION " is needed" + whence);
}

}  // namespace covis::io
