// SPDX-License-Identifier: Apache-2.0
#include "covis/storage/map_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <utility>

#include "covis/core/atomic_file.h"
#include "covis/core/log.h"
#include "covis/geometry/camera_check.h"
#include "covis/storage/load_cost.h"
#include "covis/storage/map_anchors.h"
#include "covis/storage/map_cameras.h"
#include "covis/storage/map_colours.h"
#include "covis/storage/map_file_format.h"
#include "covis/storage/map_file_layout.h"
#include "covis/storage/map_header_check.h"
#include "covis/storage/map_writing.h"

namespace covis::storage {
namespace {

// A camera's file, say, must not be lost because its name was given for the map's.
Result<void> check_replaceable(const std::filesystem::path& file) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(file, none) || std::filesystem::file_size(file, none) == 0) return {};
  if (is_map_file(file)) return {};
  return fail(
      file.string() +
      ": it is there and is not a map of Covis, so that no map is written over it; give another name or remove it");
}

// ---- Reading ----

struct About {
  MapHeader header;
  Counts counts;
};

Result<About> read_about(SectionFile& file) {
  const auto bytes = file.read(kAbout, "about");
  if (!bytes) return tl::unexpected(bytes.error());
  FieldReader fields(*bytes);
  About about;
  about_fields(fields, about.header, about.counts);
  if (!fields.whole()) return fail(file.error(kNotRightLength));
  std::string problem = problem_of(about.header);
  const Counts& c = about.counts;
  if (problem.empty()) problem = problem_of_counts(c.key_frames, c.points, c.features, file.size());
  if (!problem.empty()) return fail(file.error(problem));
  return about;
}

// Reads the key frames without features and observations; `records` receives their remaining fields.
Result<std::vector<KeyFrameState>> read_key_frames(SectionFile& file, uint32_t count,
                                                   std::vector<FrameRecord>& records) {
  const auto bytes = file.read(kKeyFrames, "key frames");
  if (!bytes) return tl::unexpected(bytes.error());
  FieldReader fields(*bytes);
  std::vector<KeyFrameState> key_frames;
  key_frames.reserve(count);
  records.reserve(count);
  for (uint32_t i = 0; i < count && fields.ok(); ++i) {
    KeyFrameState& k = key_frames.emplace_back();
    FrameRecord& r = records.emplace_back();
    key_frame_fields(fields, k, r);
    k.T_cw = SE3(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r.R.data()),
                 Eigen::Map<const Eigen::Vector3d>(r.t.data()));
  }
  if (!fields.whole()) return fail(file.error(kNotRightLength));
  return key_frames;
}

bool same_bits(const AlignedVector<float>& a, const AlignedVector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](float p, float q) { return std::bit_cast<uint32_t>(p) == std::bit_cast<uint32_t>(q); });
}

// The size of a pixel of each key frame (ScalePyramid::base). Files of one camera have none.
Result<std::vector<float>> read_pixel_sizes(SectionFile& file, size_t key_frames) {
  std::vector<float> sizes(key_frames, 1);
  if (!file.has(kPixelSizes)) return sizes;
  const auto bytes = file.read(kPixelSizes, "pixel sizes");
  if (!bytes) return tl::unexpected(bytes.error());
  FieldReader fields(*bytes);
  for (float& size : sizes) fields(size);
  if (!fields.whole()) return fail(file.error(kNotRightLength));
  if (!std::all_of(sizes.begin(), sizes.end(), valid_pixel_size))
    return fail(file.error("a key frame has no valid size of its pixels"));
  return sizes;
}

// Files without several cameras have none. The residual distortions of all cameras are read, `own` is the map's.
Result<KeyFrameCameras> read_key_frame_cameras(SectionFile& file, size_t key_frames, Pinhole& own) {
  KeyFrameCameras cameras;
  if (file.has(kCameras)) {
    const auto bytes = file.read(kCameras, "cameras");
    if (!bytes) return tl::unexpected(bytes.error());
    if (const std::string problem = read_cameras(*bytes, key_frames, cameras); !problem.empty())
      return fail(file.error(problem));
  }
  if (file.has(kResiduals)) {
    const auto bytes = file.read(kResiduals, "residual distortions");
    if (!bytes) return tl::unexpected(bytes.error());
    if (const std::string problem = read_residuals(*bytes, own, cameras); !problem.empty())
      return fail(file.error(problem));
  }
  return cameras;
}

// Those of each key frame; empty lists for files without anchors.
Result<std::vector<AlignedVector<uint64_t>>> read_all_anchors(SectionFile& file,
                                                              const std::vector<FrameRecord>& records,
                                                              uint32_t next_serial) {
  std::vector<AlignedVector<uint64_t>> anchors;
  if (!file.has(kAnchors)) return std::vector<AlignedVector<uint64_t>>(records.size());
  const auto bytes = file.read(kAnchors, "anchors");
  if (!bytes) return tl::unexpected(bytes.error());
  std::vector<uint32_t> features;
  for (const FrameRecord& record : records) features.push_back(record.features);
  if (const std::string problem = read_anchors(*bytes, features, next_serial, anchors); !problem.empty())
    return fail(file.error(problem));
  return anchors;
}

// The map gets key frames' features, and its camera the residual distortion.
Result<void> read_features(SectionFile& file, const std::vector<FrameRecord>& records, MapState& map) {
  const auto sizes = read_pixel_sizes(file, records.size());
  if (!sizes) return tl::unexpected(sizes.error());
  const auto cameras = read_key_frame_cameras(file, records.size(), map.camera);
  if (!cameras) return tl::unexpected(cameras.error());
  auto anchors = read_all_anchors(file, records, map.next_serial);
  if (!anchors) return tl::unexpected(anchors.error());
  const auto straightened_for = map.camera.residual.any() ? std::make_shared<const Pinhole>(map.camera) : nullptr;
  const auto right_columns = shared_field(map.camera.right_columns);
  std::vector<std::shared_ptr<const RefinedCamera>> made_by{nullptr};
  for (const RefinedCamera& other : cameras->cameras) made_by.push_back(std::make_shared<RefinedCamera>(other));
  const auto bytes = file.read(kFeatures, "features");
  if (!bytes) return tl::unexpected(bytes.error());
  FieldReader fields(*bytes);
  std::shared_ptr<const ScalePyramid> pyramid;
  for (size_t i = 0; i < records.size(); ++i) {
    const FrameRecord& r = records[i];
    const std::string name = "key frame " + std::to_string(i) + " ";
    if (!valid_pyramid(r.levels, r.factor)) return fail(file.error(name + "has no valid pyramid"));
    if (!pyramid || pyramid->levels != r.levels || pyramid->factor != r.factor || pyramid->base != (*sizes)[i]) {
      pyramid = std::make_shared<ScalePyramid>(r.levels, r.factor, (*sizes)[i]);  // usually one for all key frames
    }
    const auto f = std::make_shared<Features>();
    AlignedVector<float> image_x, image_y;
    for_each_array(*f, image_x, image_y, [&](auto& array) { fields.sized_list(array, r.features); });
    if (!fields.ok()) break;
    if (!same_bits(image_x, f->x) || !same_bits(image_y, f->y)) {
      f->raw_x = std::move(image_x);
      f->raw_y = std::move(image_y);
    }
    f->pyramid = pyramid;
    f->straightened_for = straightened_for;
    f->right_columns = right_columns;
    if (!cameras->of.empty()) f->made_by = made_by[cameras->of[i]];
    if (!valid_camera(r.camera)) return fail(file.error(name + "has no valid camera"));
    const std::string problem = covis::problem_of(*f, r.bounds);
    if (!problem.empty()) return fail(file.error(name + problem));
    f->grid.build(r.bounds, f->x, f->y);
    f->anchor = std::move((*anchors)[i]);
    map.key_frames[i].features = f;
  }
  if (!fields.whole()) return fail(file.error(kNotRightLength));
  return {};
}

Result<void> read_observations(SectionFile& file, std::vector<KeyFrameState>& key_frames) {
  const auto bytes = file.read(kObservations, "observations");
  if (!bytes) return tl::unexpected(bytes.error());
  FieldReader fields(*bytes);
  for (KeyFrameState& k : key_frames) fields.sized_list(k.points, static_cast<size_t>(k.features->size()));
  if (!fields.whole()) return fail(file.error(kNotRightLength));
  return {};
}

Result<void> read_points(SectionFile& file, uint32_t count, std::vector<MapPointState>& points) {
  const auto bytes = file.read(kPoints, "points");
  if (!bytes) return tl::unexpected(bytes.error());
  FieldReader fields(*bytes);
  points.reserve(count);
  for (uint32_t i = 0; i < count && fields.ok(); ++i) point_fields(fields, points.emplace_back());
  if (!fields.whole()) return fail(file.error(kNotRightLength));
  return {};
}

// Returns the camera of all key frames. Early versions could leave key frames of two cameras in a map. The first key
// frame's camera is used then, as those versions did in every adjustment.
Pinhole camera_of(const std::vector<FrameRecord>& records, const SectionFile& file) {
  const Pinhole& first = records.front().camera;
  const auto others =
      std::count_if(records.begin(), records.end(), [&](const FrameRecord& r) { return r.camera != first; });
  if (others > 0) {
    log(LogLevel::warning, file.error("its key frames have several cameras, " + std::to_string(others) +
                                      " of them not the first one's: the first camera is used for all"));
  }
  return first;
}

// Files of other sensors have none; nor have those of versions before 1.2, which mean a Kinect's.
Result<DepthNoise> read_depth_noise(SectionFile& file, Sensor sensor) {
  DepthNoise noise;
  if (!file.has(kDepthNoise)) return sensor == Sensor::rgbd && file.minor() < 2 ? DepthNoise::kinect() : noise;
  const auto bytes = file.read(kDepthNoise, "depth noise");
  if (!bytes) return tl::unexpected(bytes.error());
  FieldReader fields(*bytes);
  fields(noise.a);
  fields(noise.b);
  if (!fields.whole()) return fail(file.error(kNotRightLength));
  if (!noise.valid()) return fail(file.error("its noise of depth is not valid"));
  return noise;
}

Result<DepthRegistration> read_registration(SectionFile& file) {
  DepthRegistration registration;
  if (!file.has(kRegistration)) return registration;
  const auto bytes = file.read(kRegistration, "registration of depth");
  if (!bytes) return tl::unexpected(bytes.error());
  FieldReader fields(*bytes);
  registration_fields(fields, registration);
  if (!fields.whole()) return fail(file.error(kNotRightLength));
  if (!registration.valid()) return fail(file.error("its registration of depth is not valid"));
  return registration;
}

Result<double> read_row_time(SectionFile& file, int image_height) {
  constexpr double kRounding = 1e-9;  // seconds
  double row_time = 0;
  if (!file.has(kShutter)) return row_time;
  const auto bytes = file.read(kShutter, "rolling shutter");
  if (!bytes) return tl::unexpected(bytes.error());
  FieldReader fields(*bytes);
  fields(row_time);
  if (!fields.whole()) return fail(file.error(kNotRightLength));
  // Not the other way about: it may be a NaN.
  if (!(std::abs(row_time * image_height) <= CameraBounds::kLongestReadout + kRounding))
    return fail(file.error("its rolling shutter is not valid"));
  return row_time;
}

Result<ShiftField> read_right_columns(SectionFile& file) {
  ShiftField columns;
  if (!file.has(kRightColumns)) return columns;
  const auto bytes = file.read(kRightColumns, "right columns");
  if (!bytes) return tl::unexpected(bytes.error());
  FieldReader fields(*bytes);
  fields.array(columns.pixels.data(), columns.pixels.size());
  if (!fields.whole()) return fail(file.error(kNotRightLength));
  if (!columns.valid()) return fail(file.error("its right columns are not valid"));
  return columns;
}

// Things that a map learned of its camera, and no key frame's record has.
Result<void> read_learned(SectionFile& file, int image_height, Pinhole& camera) {
  const auto registration = read_registration(file);
  if (!registration) return tl::unexpected(registration.error());
  const auto row_time = read_row_time(file, image_height);
  if (!row_time) return tl::unexpected(row_time.error());
  const auto columns = read_right_columns(file);
  if (!columns) return tl::unexpected(columns.error());
  camera.registration = *registration;
  camera.row_time = *row_time;
  camera.right_columns = *columns;
  return {};
}

Result<void> read_colours(SectionFile& file, std::vector<KeyFrameState>& key_frames) {
  if (!file.has(kColours)) return {};
  const auto bytes = file.read(kColours, "colours");
  if (!bytes) return tl::unexpected(bytes.error());
  if (const std::string problem = take_colours(*bytes, key_frames); !problem.empty()) return fail(file.error(problem));
  return {};
}

Result<MapState> read_state(SectionFile& file, const Counts& counts, const MapHeader& header) {
  MapState state;
  state.root = counts.root;
  state.next_serial = counts.next_serial;
  std::vector<FrameRecord> records;
  auto key_frames = read_key_frames(file, counts.key_frames, records);
  if (!key_frames) return tl::unexpected(key_frames.error());
  state.key_frames = std::move(*key_frames);
  state.camera = records.empty() ? header.camera.pinhole : camera_of(records, file);
  const auto noise = read_depth_noise(file, header.sensor);
  if (!noise) return tl::unexpected(noise.error());
  state.camera.depth_noise = *noise;
  Result<void> read = read_learned(file, header.camera.height, state.camera);
  if (read) read = read_features(file, records, state);
  if (read) read = read_observations(file, state.key_frames);
  if (read) read = read_points(file, counts.points, state.points);
  if (read) read = read_colours(file, state.key_frames);
  if (read) read = file.verify_others();
  if (!read) return tl::unexpected(read.error());
  if (counts_of(state) != counts) return fail(file.error("it is damaged: its contents do not match its counts"));
  std::string problem = covis::problem_of(state);
  if (problem.empty()) problem = problem_of_meetings(meetings_of(state), state, file.size());
  if (!problem.empty()) return fail(file.error("its map is not sound: " + problem));
  return state;
}

}  // namespace

Result<void> check_save_target(const std::filesystem::path& file) {
  if (auto replaceable = check_replaceable(file); !replaceable) return replaceable;
  return check_writable(file);
}

Result<void> save_map(const std::filesystem::path& file, const MapState& map, const MapHeader& header) {
  if (auto replaceable = check_replaceable(file); !replaceable) return replaceable;
  std::string problem = problem_of(header);
  if (problem.empty()) problem = covis::problem_of(map);
  if (!problem.empty()) return fail(file.string() + ": the map is not sound and was not saved: " + problem);
  const auto write = [&](FileSink& sink) -> Result<void> {
    auto written = write_map(sink, map, header);
    return written ? written : fail(file.string() + ": " + written.error().message);
  };
  return write_atomically(file, write, Durability::durable);
}

Result<SavedMap> load_map(const std::filesystem::path& path) {
  auto file = SectionFile::open(path);
  if (!file) return tl::unexpected(file.error());
  const auto about = read_about(*file);
  if (!about) return tl::unexpected(about.error());
  auto state = read_state(*file, about->counts, about->header);
  if (!state) return tl::unexpected(state.error());
  auto map = Map::from_state(std::move(*state));
  if (!map) return fail(file->error("its map is not sound: " + map.error().message));
  return SavedMap{about->header, std::move(*map)};
}

Result<MapInfo> read_map_info(const std::filesystem::path& path) {
  auto file = SectionFile::open(path);
  if (!file) return tl::unexpected(file.error());
  const auto about = read_about(*file);
  if (!about) return tl::unexpected(about.error());
  std::vector<FrameRecord> records;
  const auto key_frames = read_key_frames(*file, about->counts.key_frames, records);
  if (!key_frames) return tl::unexpected(key_frames.error());
  const Counts& c = about->counts;
  MapInfo info;
  info.header = about->header;
  info.major = file->major();
  info.minor = file->minor();
  info.file_size = file->size();
  info.key_frames = c.key_frames;
  info.points = c.points;
  info.observations = c.observations;
  info.features = c.features;
  info.camera = records.empty() ? info.header.camera.pinhole : records.front().camera;
  const auto cameras = read_key_frame_cameras(*file, key_frames->size(), info.camera);
  if (!cameras) return tl::unexpected(cameras.error());
  if (auto read = read_learned(*file, info.header.camera.height, info.camera); !read)
    return tl::unexpected(read.error());
  for (const RefinedCamera& camera : cameras->cameras) info.other_cameras.push_back({camera.given, 0});
  for (const uint32_t k : cameras->of) {
    if (k > 0) ++info.other_cameras[k - 1].key_frames;
  }
  info.submaps = static_cast<uint64_t>(std::count_if(
      key_frames->begin(), key_frames->end(), [](const KeyFrameState& k) { return k.parent == MapState::kNone; }));
  if (key_frames->empty()) return info;
  Eigen::AlignedBox3d box;
  Timestamp first = key_frames->front().stamp, last = first;
  for (const KeyFrameState& k : *key_frames) {
    if (!k.T_cw.all_finite()) return fail(file->error("a key frame has a pose that is not finite"));
    box.extend(k.T_cw.centre());
    first = std::min(first, k.stamp);
    last = std::max(last, k.stamp);
  }
  info.extent = box.sizes();
  info.seconds = to_seconds(last) - to_seconds(first);
  return info;
}

}  // namespace covis::storage
