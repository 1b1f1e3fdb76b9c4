// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/map_merging.h"

#include <algorithm>
#include <memory>
#include <string>
#include <tuple>
#include <utility>

#include "covis/map/camera_change.h"
#include "covis/map/map_union.h"

namespace covis {
namespace {

// Among equal ones the order in which they are given must not matter.
size_t best_camera(const std::vector<MergeSource>& maps) {
  const auto rank = [](const MergeSource& source) {
    const MapState& map = source.map;
    const bool depth = source.sensor != Sensor::monocular, stereo = source.sensor == Sensor::stereo;
    // A distortion, a registration and a rolling shutter that were found are kept.
    const ResidualDistortion& residual = map.camera.residual;
    const DepthRegistration& r = map.camera.registration;
    return std::tuple(depth, stereo, residual.any(), r.any(), map.camera.row_time != 0, map.key_frames.size(),
                      map.points.size(), map.camera.fx, map.camera.fy, residual.k1, residual.k2, r.scale, r.shift_x,
                      r.shift_y, r.parallax_x, r.parallax_y, map.camera.row_time);
  };
  const auto best = std::max_element(maps.begin(), maps.end(),
                                     [&](const MergeSource& a, const MergeSource& b) { return rank(a) < rank(b); });
  return static_cast<size_t>(best - maps.begin());
}

// The submaps of each input: its key frames have the serials that follow those of the input before.
void find_inputs(const Map& map, std::vector<MergedInput>& inputs) {
  for (const Submap& submap : map.submaps()) {
    const uint32_t serial = map.at(submap.root).serial;
    const auto next = std::ranges::upper_bound(inputs, serial, {}, &MergedInput::first_serial);
    (next - 1)->submaps.push_back(submap.id);
  }
}

}  // namespace

Result<MergeReport> merge_maps(std::vector<MergeSource> maps, const Vocabulary& vocabulary, const LoopOptions& options,
                               SharedMap& merged) {
  MergeReport report;
  if (maps.empty()) return report;
  report.camera_of = best_camera(maps);
  const Pinhole camera = maps[report.camera_of].map.camera;
  std::vector<size_t> to_adjust;  // inputs whose camera is another one from now on
  MapState all;
  const Camera given = maps[report.camera_of].given;
  const Sensor sensor = maps[report.camera_of].sensor;
  for (size_t i = 0; i < maps.size(); ++i) {
    MapState& map = maps[i].map;
    report.inputs.push_back({{}, all.next_serial, map.key_frames.size(), map.points.size()});
    const bool refined =
        map.camera.fx != camera.fx || map.camera.fy != camera.fy || !same_corrections(map.camera, camera);
    // Keypoints of other cameras were expressed in what the camera was refined to, and would not fit another focal
    // length.
    const bool is_same = maps[i].sensor == sensor && difference(given, maps[i].given).empty();
    if (!is_same || (refined && has_other_cameras(map))) {
      if (auto fits = express_in(map, maps[i].given, {given, camera}); !fits) return tl::unexpected(fits.error());
    } else if (refined) {
      straighten(map, camera);
      to_adjust.push_back(i);
    }
    if (const auto added = append_map(all, std::move(map)); !added) return tl::unexpected(added.error());
  }
  all.camera = camera;
  if (other_cameras(all).size() > kMostCameras)
    return fail("the maps name more than " + std::to_string(kMostCameras) + " cameras, which is the most for one map");
  auto map = Map::from_state(std::move(all));
  if (!map) return tl::unexpected(map.error());
  find_inputs(*map, report.inputs);
  for (const KeyFrameId& id : map->key_frames())
    map->set_words(id, std::make_shared<const Words>(vocabulary.transform(map->at(id).features->descriptor)));
  *merged.write() = std::move(*map);
  for (const size_t i : to_adjust) {
    for (const uint32_t submap : report.inputs[i].submaps) adjust_submap(merged, submap, options.ba_iterations);
  }
  report.join = join_submaps(merged, {.sensor = sensor, .loop = options, .mapper = {}, .seed = 0});
  return report;
}

}  // namespace covis
