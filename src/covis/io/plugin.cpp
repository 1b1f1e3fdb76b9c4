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

// The folder of the program or shared library that this code is linked into. It never depends on the working folder,
// which may be anyone's.
Result<fs::path> own_folder() {
  Dl_info info{};
  void* map = nullptr;
  if (dladdr1(reinterpret_cast<const void*>(&own_folder), &info, &map, RTLD_DL_LINKMAP) == 0)
    return fail("the dynamic loader does not know the program");
  std::error_code error;
  fs::path own = static_cast<const link_map*>(map)->l_name;
  if (own.empty()) own = fs::read_symlink("/proc/self/exe", error);  // a program has no name there
  if (error) return fail("/proc/self/exe: " + error.message());
  if (!own.is_absolute()) return fail("Covis was loaded by a relative path, " + own.string());
  own = fs::weakly_canonical(own, error);
  if (error) return fail(own.string() + ": " + error.message());
  return own.parent_path();
}

// A plug-in may lie beside the program, as in a folder that was copied and in the Python package; or where it is
// installed, as seen from the command and from programs one folder below the build's; or as seen from those in the
// build's own folder.
fs::path file_of(const char* name, const fs::path& folder) {
  const fs::path installed = (folder / COVIS_PLUGINS_FROM_BIN).lexically_normal();
  const std::string file = std::string(name) + ".so";
  for (const fs::path& place : {folder, installed, folder / COVIS_PLUGINS}) {
    std::error_code error;
    if (fs::exists(place / file, error)) return place / file;
  }
  return installed / file;
}

}  // namespace

Result<const void*> open_plugin(const char* name, const char* purpose) {
  const std::string whence =
      ". It is installed with the command (Debian's package covis) and with the Python package (python3-covis)";
  const auto problem = [&](const std::string& what) {
    return fail(std::string(name) + ".so, which " + purpose + ", " + what + whence);
  };
  const auto folder = own_folder();
  if (!folder) return problem("can't be looked for: " + folder.error().message);
  const fs::path file = file_of(name, *folder);
  void* const opened = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!opened) {
    const char* const reason = dlerror();  // it names the file
    return problem(std::string("can't be opened: ") + (reason ? reason : ""));
  }
  const auto version = reinterpret_cast<const char* (*)()>(dlsym(opened, "covis_plugin_version"));
  const auto table = reinterpret_cast<const void* (*)()>(dlsym(opened, "covis_plugin_table"));
  if (version && table && std::string_view(version()) == COVIS_PLUGIN_VERSION) return table();
  const std::string of = version ? std::string(" is of Covis ") + version() : " does not say its version";
  dlclose(opened);
  return problem("can't be used: " + file.string() + of + ", and this is Covis " COVIS_PLUGIN_VERSION);
}

}  // namespace covis::io
