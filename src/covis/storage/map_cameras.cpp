// SPDX-License-Identifier: Apache-2.0
#include "covis/storage/map_cameras.h"

#include <algorithm>
#include <unordered_map>

#include "covis/map/camera_change.h"
#include "covis/storage/map_file_format.h"
#include "covis/storage/map_file_layout.h"
#include "covis/storage/map_header_check.h"

namespace covis::storage {
namespace {

template <class Fields, class C>
void refined_fields(Fields& fields, C& camera) {
  camera_fields(fields, camera.given);
  pinhole_fields(fields, camera.pinhole);
}

// All residual distortions, that of the map's camera first.
template <class Fields, class P, class Cameras>
void residual_fields(Fields& fields, P& own, Cameras& cameras) {
  const auto add = [&](auto& residual) {
    fields(residual.k1);
    fields(residual.k2);
  };
  add(own.residual);
  for (auto& camera : cameras.cameras) add(camera.pinhole.residual);
}

}  // namespace

KeyFrameCameras cameras_of(const MapState& map) {
  KeyFrameCameras all{other_cameras(map), {}};
  if (all.cameras.empty()) return all;
  all.of.reserve(map.key_frames.size());
  std::unordered_map<const RefinedCamera*, uint32_t> index{{nullptr, 0}};
  for (const KeyFrameState& k : map.key_frames) {
    const RefinedCamera* camera = k.features->made_by.get();
    const auto [at, added] = index.emplace(camera, 0);
    if (added) {
      const auto found = std::find(all.cameras.begin(), all.cameras.end(), *camera);
      at->second = static_cast<uint32_t>(found - all.cameras.begin()) + 1;
    }
    all.of.push_back(at->second);
  }
  return all;
}

std::string bytes_of(const KeyFrameCameras& all) {
  FieldWriter fields;
  fields(static_cast<uint32_t>(all.cameras.size()));
  for (const RefinedCamera& camera : all.cameras) refined_fields(fields, camera);
  fields.array(all.of.data(), all.of.size());
  return fields.take();
}

std::string read_cameras(std::string_view bytes, size_t key_frames, KeyFrameCameras& all) {
  FieldReader fields(bytes);
  uint32_t count = 0;
  fields(count);
  if (count > kMostCameras) return "it names " + std::to_string(count) + " cameras, more than a map can have";
  for (uint32_t k = 0; k < count && fields.ok(); ++k) {
    refined_fields(fields, all.cameras.emplace_back());
    const RefinedCamera& camera = all.cameras.back();
    if (!fields.ok()) break;
    const std::string problem = problem_of(camera.given);
    if (!problem.empty()) return "a key frame's camera: " + problem;
    if (!valid_camera(camera.pinhole)) return "a key frame's camera is not valid";
  }
  fields.sized_list(all.of, key_frames);
  if (!fields.whole()) return std::string(kNotRightLength);
  std::vector<bool> used(count + 1);
  for (const uint32_t k : all.of) {
    if (k > count) return "a key frame has a camera that is not there";
    used[k] = true;
  }
  if (std::find(used.begin() + 1, used.end(), false) != used.end()) return "it names a camera that made no key frame";
  return {};
}

bool have_residuals(const Pinhole& own, const KeyFrameCameras& all) {
  return own.residual.any() || std::any_of(all.cameras.begin(), all.cameras.end(),
                                           [](const RefinedCamera& camera) { return camera.pinhole.residual.any(); });
}

std::string bytes_of_residuals(const Pinhole& own, const KeyFrameCameras& all) {
  FieldWriter fields;
  residual_fields(fields, own, all);
  return fields.take();
}

std::string read_residuals(std::string_view bytes, Pinhole& own, KeyFrameCameras& all) {
  FieldReader fields(bytes);
  residual_fields(fields, own, all);
  if (!fields.whole()) return std::string(kNotRightLength);
  const auto valid = [](const RefinedCamera& camera) { return valid_camera(camera.pinhole); };
  if (!valid_camera(own) || !std::all_of(all.cameras.begin(), all.cameras.end(), valid))
    return "a camera's residual distortion is not valid";
  return {};
}

}  // namespace covis::storage
