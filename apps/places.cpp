// SPDX-License-Identifier: Apache-2.0
#include "places.h"

#include <cstdio>

namespace covis::app {
namespace {

constexpr const char* kDefault = "default.covis-voc";

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

}  // namespace

System::Input input_of(const io::Frame& frame) {
  return {.frame = frame.index,
          .stamp = frame.stamp,
          .image = frame.image.view(),
          .right = frame.right.view(),
          .depth = frame.depth.view()};
}

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

io::MapHeader map_header(const Camera& camera, const SystemOptions& options, const Vocabulary* vocabulary) {
  io::MapHeader header;
  header.camera = camera;
  header.sensor = options.sensor;
  header.levels = options.orb.levels;
  header.factor = static_cast<float>(options.orb.scale_factor);
  if (vocabulary) {
    char text[20];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(vocabulary->checksum()));
    header.vocabulary = text;
  }
  return header;
}

Result<io::SavedMap> open_map(const std::filesystem::path& file, const SystemOptions& options) {
  auto saved = io::load_map(file);
  if (!saved) return tl::unexpected(saved.error());
  const io::MapHeader& header = saved->header;
  if ((header.sensor == Sensor::monocular) != (options.sensor == Sensor::monocular)) {
    return fail(file.string() + ": the map was made " +
                (header.sensor == Sensor::monocular ? "by a monocular camera, whose unit of length is arbitrary"
                                                    : "by a camera with depth, in metres") +
                "; the recording is of the other kind (--sensor)");
  }
  if (header.levels != options.orb.levels || header.factor != static_cast<float>(options.orb.scale_factor)) {
    return fail(file.string() + ": the map was made with orb.levels " + std::to_string(header.levels) +
                " and orb.scale_factor " + number(static_cast<double>(header.factor)) + "; use the same");
  }
  if (saved->map.key_frame_count() == 0) return fail(file.string() + ": the map is empty");
  return saved;
}

}  // namespace covis::app
