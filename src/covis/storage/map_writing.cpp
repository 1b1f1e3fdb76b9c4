// SPDX-License-Identifier: Apache-2.0
#include "covis/storage/map_writing.h"

#include <string>

#include "covis/map/camera_change.h"
#include "covis/storage/load_cost.h"
#include "covis/storage/map_anchors.h"
#include "covis/storage/map_cameras.h"
#include "covis/storage/map_colours.h"
#include "covis/storage/map_file_format.h"
#include "covis/storage/map_file_layout.h"

namespace covis::storage {
namespace {

FrameRecord record_of(const KeyFrameState& k, const Pinhole& camera) {
  const Features& f = *k.features;
  FrameRecord r;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r.R.data()) = k.T_cw.R();
  Eigen::Map<Eigen::Vector3d>(r.t.data()) = k.T_cw.t();
  r.camera = camera;
  r.bounds = f.grid.bounds;
  r.features = static_cast<uint32_t>(f.size());
  r.levels = f.pyramid->levels;
  r.factor = f.pyramid->factor;
  return r;
}

// Calls add(bytes) with the features of each key frame in turn.
template <class Add>
void add_features(const MapState& map, Add&& add) {
  for (const KeyFrameState& k : map.key_frames) {
    FieldWriter features;
    for_each_array(*k.features, k.features->image_x(), k.features->image_y(),
                   [&](const auto& array) { features.array(array.data(), array.size()); });
    add(features.take());
  }
}

uint64_t bytes_of_features(const MapState& map) {
  uint64_t size = 0;
  for (const KeyFrameState& k : map.key_frames) {
    for_each_array(*k.features, k.features->image_x(), k.features->image_y(),
                   [&](const auto& array) { size += array.size() * sizeof array[0]; });
  }
  return size;
}

std::string key_frame_bytes(const MapState& map) {
  FieldWriter key_frames;
  for (const KeyFrameState& k : map.key_frames) {
    const FrameRecord record = record_of(k, map.camera);
    key_frame_fields(key_frames, k, record);
  }
  return key_frames.take();
}

std::string observation_bytes(const MapState& map) {
  FieldWriter observations;
  for (const KeyFrameState& k : map.key_frames) observations.array(k.points.data(), k.points.size());
  return observations.take();
}

std::string point_bytes(const MapState& map) {
  FieldWriter points;
  for (const MapPointState& p : map.points) point_fields(points, p);
  return points.take();
}

std::string pixel_size_bytes(const MapState& map) {
  FieldWriter sizes;
  for (const KeyFrameState& k : map.key_frames) sizes(k.features->pyramid->base);
  return sizes.take();
}

// A file that a reader would refuse is no map.
Result<void> check_readable(const MapState& map, uint64_t size) {
  const std::string problem = problem_of_meetings(meetings_of(map), map, size);
  if (problem.empty()) return {};
  return fail("the map is not sound and was not saved: " + problem);
}

}  // namespace

Result<void> write_map(FileSink& sink, const MapState& map, const MapHeader& header) {
  const bool noise = map.camera.depth_noise.known(), colours = has_colours(map), sizes = has_other_pixels(map);
  const KeyFrameCameras others = cameras_of(map);
  const bool cameras = !others.cameras.empty(), residuals = have_residuals(map.camera, others);
  const bool anchors = has_anchors(map), registration = map.camera.registration.any(),
             shutter = map.camera.row_time != 0, columns = map.camera.right_columns.any();
  const uint16_t minor = columns        ? kMapFileMinor
                         : shutter      ? kMapFileMinorWithShutter
                         : registration ? kMapFileMinorWithRegistration
                         : anchors      ? kMapFileMinorWithAnchors
                         : residuals    ? kMapFileMinorWithResiduals
                         : cameras      ? kMapFileMinorWithCameras
                         : sizes        ? kMapFileMinorWithSizes
                         : colours      ? kMapFileMinorWithColours
                                        : kMapFileMinorLeast;
  SectionWriter file(sink,
                     5u + noise + colours + sizes + cameras + residuals + anchors + registration + shutter + columns,
                     kMapFileMajor, minor);
  FieldWriter about;
  const Counts counts = counts_of(map);
  about_fields(about, header, counts);
  file.write(kAbout, about.take());
  file.write(kKeyFrames, key_frame_bytes(map));
  file.begin(kFeatures, bytes_of_features(map));
  add_features(map, [&](const std::string& piece) { file.add(piece); });
  file.end();
  file.write(kObservations, observation_bytes(map));
  file.write(kPoints, point_bytes(map));
  if (noise) {
    FieldWriter fields;
    fields(map.camera.depth_noise.a);
    fields(map.camera.depth_noise.b);
    file.write(kDepthNoise, fields.take());
  }
  if (colours) file.write(kColours, colour_bytes(map));
  if (sizes) file.write(kPixelSizes, pixel_size_bytes(map));
  if (cameras) file.write(kCameras, bytes_of(others));
  if (residuals) file.write(kResiduals, bytes_of_residuals(map.camera, others));
  if (anchors) file.write(kAnchors, anchor_bytes(map));
  if (registration) {
    FieldWriter fields;
    registration_fields(fields, map.camera.registration);
    file.write(kRegistration, fields.take());
  }
  if (shutter) {
    FieldWriter fields;
    fields(map.camera.row_time);
    file.write(kShutter, fields.take());
  }
  if (columns) {
    FieldWriter fields;
    fields.array(map.camera.right_columns.pixels.data(), ShiftField::kTerms);
    file.write(kRightColumns, fields.take());
  }
  const auto size = file.finish();
  return size ? check_readable(map, *size) : tl::unexpected(size.error());
}

}  // namespace covis::storage
