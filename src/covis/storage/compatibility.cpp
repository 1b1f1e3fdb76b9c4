// SPDX-License-Identifier: Apache-2.0
#include "covis/storage/compatibility.h"

#include <cstdio>
#include <string>

namespace covis::storage {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

}  // namespace

MapHeader header_of(const Camera& camera, Sensor sensor, const OrbOptions& orb, const Vocabulary* vocabulary) {
  MapHeader header;
  header.camera = camera;
  header.sensor = sensor;
  header.levels = pyramid_levels(orb, camera.width, camera.height);
  header.factor = static_cast<float>(orb.scale_factor);
  if (vocabulary) {
    char text[20];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(vocabulary->checksum()));
    header.vocabulary = text;
  }
  return header;
}

MapHeader header_after(const MapHeader& run, const MapHeader& saved) {
  MapHeader header = run;
  if (difference(run.camera, saved.camera).empty()) header.camera = saved.camera;
  if (run.sensor == Sensor::monocular && saved.sensor != Sensor::monocular) {
    header.sensor = saved.sensor;
    header.camera.pinhole.bf = saved.camera.pinhole.baseline() * header.camera.pinhole.fx;
  }
  return header;
}

Result<void> check_compatible(const MapHeader& saved, const MapHeader& run, MapUse use) {
  const bool monocular = saved.sensor == Sensor::monocular;
  const bool in_metres = !monocular && use == MapUse::localization;  // the map tells a camera without depth its unit
  if (monocular != (run.sensor == Sensor::monocular) && !in_metres) {
    return fail(
        std::string("the map was made ") +
        (monocular ? "by a monocular camera, whose unit of length is arbitrary" : "by a camera with depth, in metres") +
        "; the recording is of the other kind (--sensor)" +
        (monocular ? "" : "; it can be localised in it only (--localize)"));
  }
  if (saved.factor != run.factor)
    return fail("the map was made with orb.scale_factor " + number(static_cast<double>(saved.factor)) +
                "; use the same");
  return {};
}

Result<void> check_mergeable(const MapHeader& first, const MapHeader& other) {
  if (other.factor == first.factor) return {};
  return fail("it was made with orb.scale_factor " + number(static_cast<double>(other.factor)) + " instead of " +
              number(static_cast<double>(first.factor)) + ": a map has one kind of features");
}

Result<SavedMap> load_compatible_map(const std::filesystem::path& file, const MapHeader& run, MapUse use) {
  auto saved = load_map(file);
  if (!saved) return saved;
  if (const auto fits = check_compatible(saved->header, run, use); !fits)
    return fail(file.string() + ": " + fits.error().message);
  if (saved->map.key_frame_count() == 0) return fail(file.string() + ": the map is empty");
  return saved;
}

}  // namespace covis::storage
