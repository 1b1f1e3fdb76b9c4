// SPDX-License-Identifier: Apache-2.0
#include "places.h"

namespace covis::app {
namespace {

constexpr const char* kDefault = "default.covis-voc";

}  // namespace

Result<std::shared_ptr<const Vocabulary>> open_vocabulary(const std::string& name) {
  if (name == "none") return nullptr;
  if (!name.empty()) return Vocabulary::load(name);
  std::error_code error;
  const std::filesystem::path command = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path installed = command.parent_path() / COVIS_SHARE_FROM_BIN / kDefault;
  for (const std::filesystem::path& file : {installed, std::filesystem::path(COVIS_VOCABULARY_FOLDER) / kDefault}) {
    if (std::filesystem::exists(file, error)) return Vocabulary::load(file);
  }
  return fail(installed.string() + ": the default vocabulary is missing; give one by --vocabulary FILE, or " +
              "--vocabulary none to do without recognising places");
}

}  // namespace covis::app
