// SPDX-License-Identifier: Apache-2.0
// The sections of a map file, field by field (docs/map-format.md). Each function serves both directions, with
// FieldWriter or FieldReader as Fields.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "covis/map/map_state.h"
#include "covis/storage/map_file.h"

namespace covis::storage {

// Identifiers of the sections.
inline constexpr uint32_t kAbout = 1, kKeyFrames = 2, kFeatures = 3, kObservations = 4, kPoints = 5, kDepthNoise = 6,
                          kPixelSizes = 8, kRegistration = 12, kShutter = 13, kRightColumns = 14;

struct Counts {
  uint32_t key_frames = 0, points = 0, root = MapState::kNone, next_serial = 0;
  uint64_t features = 0, observations = 0;
  friend bool operator==(const Counts&, const Counts&) = default;
};

inline Counts counts_of(const MapState& map) {
  Counts c{static_cast<uint32_t>(map.key_frames.size()), static_cast<uint32_t>(map.points.size()), map.root,
           map.next_serial};
  for (const KeyFrameState& k : map.key_frames) {
    c.features += k.points.size();
    c.observations += k.points.size();
    c.observations -= static_cast<uint64_t>(std::count(k.points.begin(), k.points.end(), MapState::kNone));
  }
  return c;
}

template <class Fields, class P>
void pinhole_fields(Fields& fields, P& p) {
  for (auto* value : {&p.fx, &p.fy, &p.cx, &p.cy, &p.bf}) fields(*value);
}

template <class Fields, class R>
void registration_fields(Fields& fields, R& r) {
  for (auto* value : {&r.scale, &r.shift_x, &r.shift_y, &r.parallax_x, &r.parallax_y}) fields(*value);
}

template <class Fields, class C>
void camera_fields(Fields& fields, C& camera) {
  fields(camera.width);
  fields(camera.height);
  pinhole_fields(fields, camera.pinhole);
  fields(camera.distortion);
  fields.array(camera.coefficients.data(), camera.coefficients.size());
}

template <class Fields, class H, class C>
void about_fields(Fields& fields, H& h, C& c) {
  camera_fields(fields, h.camera);
  fields(h.sensor);
  fields(h.levels);
  fields(h.factor);
  fields.list(h.vocabulary);
  fields(c.key_frames);
  fields(c.points);
  fields(c.root);
  fields(c.next_serial);
  fields(c.features);
  fields(c.observations);
}

// The fixed-size fields of a key frame, independent of its number of features.
struct FrameRecord {
  std::array<double, 9> R{};  // row-major
  std::array<double, 3> t{};
  Pinhole camera;
  ImageBounds bounds;
  uint32_t features = 0;
  int32_t levels = 0;
  float factor = 0;
};

template <class Fields, class K, class R>
void key_frame_fields(Fields& fields, K& k, R& record) {
  fields(k.serial);
  fields(k.frame);
  fields(k.stamp);
  fields.array(record.R.data(), record.R.size());
  fields.array(record.t.data(), record.t.size());
  fields(k.parent);
  fields(record.features);
  pinhole_fields(fields, record.camera);
  for (auto* value : {&record.bounds.min_x, &record.bounds.min_y, &record.bounds.max_x, &record.bounds.max_y}) {
    fields(*value);
  }
  fields(record.levels);
  fields(record.factor);
  fields.list(k.loop_edges);
}

// Calls visit(array) for each array of the features, in the order of the file. `image_x` and `image_y` are the raw
// pixels, which the file always contains.
template <class F, class Pixels, class Visit>
void for_each_array(F& f, Pixels& image_x, Pixels& image_y, Visit&& visit) {
  for (auto* array : {&f.x, &f.y}) visit(*array);
  for (auto* array : {&image_x, &image_y}) visit(*array);
  for (auto* array : {&f.angle, &f.u_right, &f.depth}) visit(*array);
  visit(f.level);
  visit(f.descriptor);
}

template <class Fields, class P>
void point_fields(Fields& fields, P& p) {
  fields.array(p.position_w.data(), 3);
  fields.array(p.normal_w.data(), 3);
  fields.array(p.descriptor.bits.data(), p.descriptor.bits.size());
  fields(p.d_min);
  fields(p.d_max);
  fields(p.reference);
  uint32_t reserved = 0;  // written as 0, which earlier readers accept; what a file has here is not looked at
  fields(reserved);
  fields(p.visible);
  fields(p.found);
}

}  // namespace covis::storage
