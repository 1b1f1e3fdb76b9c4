// SPDX-License-Identifier: Apache-2.0
#include "apps/view/view_state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

namespace covis::view {
namespace {

constexpr std::string_view kMagic = "COVISVW1";

// Walks two lists that are sorted by `key`. Rows of `now` that `before` lacks or has otherwise go to `changed`, the
// keys of rows that are gone to `removed`.
template <class Row, class Key, class Removed>
void compare(const std::vector<Row>& before, const std::vector<Row>& now, Key key, std::vector<Row>& changed,
             std::vector<Removed>& removed) {
  auto old = before.begin();
  for (const Row& row : now) {
    for (; old != before.end() && key(*old) < key(row); ++old) removed.push_back(key(*old));
    const bool known = old != before.end() && key(*old) == key(row);
    if (!known || !(*old == row)) changed.push_back(row);
    if (known) ++old;
  }
  for (; old != before.end(); ++old) removed.push_back(key(*old));
}

template <class Row, class Key>
void write_changes(const std::vector<Row>& before, const std::vector<Row>& now, Key key, Block kind, Block gone,
                   BlockWriter& out) {
  std::vector<Row> changed;
  std::vector<std::decay_t<decltype(key(now.front()))>> removed;
  compare(before, now, key, changed, removed);
  out.rows(gone, std::span(std::as_const(removed)));
  out.rows(kind, std::span(std::as_const(changed)));
}

void write_map(const MapScene& before, const MapScene& now, BlockWriter& out) {
  const auto id = [](const auto& row) { return row.id; };
  if (now.cameras != before.cameras) out.rows(Block::cameras, std::span(now.cameras));
  write_changes(before.key_frames, now.key_frames, id, Block::key_frames, Block::key_frames_removed, out);
  write_changes(before.points, now.points, id, Block::points, Block::points_removed, out);
  const auto ends = [](const EdgeRow& row) { return std::array<uint32_t, 2>{row.a, row.b}; };
  write_changes(before.edges, now.edges, ends, Block::edges, Block::edges_removed, out);
  const auto frame = [](const PathRow& row) { return row.frame; };
  write_changes(before.path, now.path, frame, Block::path, Block::path_removed, out);
}

void write_log(const RunLog& log, Sent& sent, BlockWriter& out) {
  if (sent.texts < log.texts().size()) {
    const nlohmann::json texts(
        std::vector<std::string>(log.texts().begin() + static_cast<ptrdiff_t>(sent.texts), log.texts().end()));
    out.text(Block::texts, texts.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    sent.texts = log.texts().size();
  }
  out.rows(Block::frames, std::span(log.frames()).subspan(sent.frames));
  sent.frames = log.frames().size();
  sent.loop_versions.resize(log.loops().size());
  for (size_t k = 0; k < log.loops().size(); ++k) {
    if (sent.loop_versions[k] != log.loop_versions()[k]) out.loop(static_cast<uint32_t>(k), log.loops()[k]);
  }
  sent.loop_versions = log.loop_versions();
}

template <size_t N>
bool is_finite(const std::array<float, N>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](float number) { return std::isfinite(number); });
}
bool is_finite(const PoseRow& pose) { return is_finite(pose.t) && is_finite(pose.q); }
bool is_finite(const CameraRow& row) { return is_finite(std::array{row.fx, row.fy, row.cx, row.cy}); }
bool is_finite(const KeyFrameRow& row) { return std::isfinite(row.stamp) && is_finite(row.pose); }
bool is_finite(const PointRow& row) { return is_finite(row.position); }
bool is_finite(const EdgeRow&) { return true; }
bool is_finite(const PathRow& row) { return is_finite(row.pose); }
bool is_finite(const FrameRow& row) {
  return std::isfinite(row.stamp) && is_finite(row.pose) && std::isfinite(row.tracking_ms) &&
         std::isfinite(row.total_ms);
}

bool is_finite(const LoopPaths& loop) {
  const auto all = [](const std::vector<PlaceRow>& places) {
    return std::all_of(places.begin(), places.end(), [](const PlaceRow& place) { return is_finite(place.position); });
  };
  return std::isfinite(loop.correction) && all(loop.before) && all(loop.after);
}

constexpr const char* kNotFinite = "one of its numbers is not finite";

// One row that is not finite would leave the page without a picture.
template <class Row>
Result<std::vector<Row>> finite_rows(const ReadBlock& block) {
  auto rows = block.rows<Row>();
  if (rows && !std::all_of(rows->begin(), rows->end(), [](const Row& row) { return is_finite(row); }))
    return fail(kNotFinite);
  return rows;
}

// Puts one block of a file into the state.
Result<void> read_block(const ReadBlock& block, MapScene& map, std::vector<LoopPaths>& loops, ViewState& state) {
  const auto append = [&](auto& list) -> Result<void> {
    auto rows = finite_rows<typename std::decay_t<decltype(list)>::value_type>(block);
    if (!rows) return tl::unexpected(rows.error());
    list.insert(list.end(), rows->begin(), rows->end());
    return {};
  };
  switch (block.kind) {
    case Block::info:
      state.info = block.body;
      return {};
    case Block::cameras:
      return append(map.cameras);
    case Block::key_frames:
      return append(map.key_frames);
    case Block::points:
      return append(map.points);
    case Block::edges:
      return append(map.edges);
    case Block::path:
      return append(map.path);
    case Block::frames: {
      const auto rows = finite_rows<FrameRow>(block);
      if (!rows) return tl::unexpected(rows.error());
      for (const FrameRow& row : *rows) state.log.add_row(row);
      return {};
    }
    case Block::texts: {
      const auto texts = nlohmann::json::parse(block.body, nullptr, false);
      if (!texts.is_array()) return fail("its texts are no list");
      for (size_t k = 1; k < texts.size(); ++k) {
        if (!texts[k].is_string()) return fail("its texts are no list of texts");
        state.log.add_text(texts[k].get<std::string>());
      }
      return {};
    }
    case Block::loop: {
      auto loop = block.loop();
      if (!loop) return tl::unexpected(loop.error());
      if (!is_finite(*loop)) return fail(kNotFinite);
      loops.push_back(std::move(*loop));
      return {};
    }
    case Block::key_frame_observations: {
      uint32_t id = 0;
      const auto rows = block.observations(id);
      if (!rows) return tl::unexpected(rows.error());
      const size_t k = map.first_observation.size() - 1;
      if (k >= map.key_frames.size() || map.key_frames[k].id != id) return fail("its observations are out of order");
      map.observations.insert(map.observations.end(), rows->begin(), rows->end());
      map.first_observation.push_back(static_cast<uint32_t>(map.observations.size()));
      return {};
    }
    default:
      return fail("it has a block of an unknown kind, " + std::to_string(static_cast<uint32_t>(block.kind)));
  }
}

Result<void> check_cameras(const MapScene& map) {
  for (const CameraRow& row : map.cameras)
    if (row.fx == 0 || row.fy == 0 || row.width == 0 || row.height == 0)
      return fail("one of its cameras has no focal length or no size");
  for (const KeyFrameRow& row : map.key_frames)
    if (row.camera > map.cameras.size())
      return fail("key frame " + std::to_string(row.id) + " is of camera " + std::to_string(row.camera) + ", it has " +
                  std::to_string(map.cameras.size()) + " beside its own");
  return {};
}

}  // namespace

std::string message_since(const ViewState& state, Sent& sent) {
  BlockWriter out;
  if (sent.info_version != state.info_version) {
    out.text(Block::info, state.info);
    sent.info_version = state.info_version;
    sent.frames = sent.texts = 0;
    sent.loop_versions.clear();
  }
  if (sent.map != state.map) {
    write_map(*sent.map, *state.map, out);
    sent.map = state.map;
  }
  write_log(state.log, sent, out);
  if (const ViewImage& image = state.image; image.frame >= 0 && image.frame != sent.image) {
    out.image({image.frame, image.width, image.height, image.keypoints, image.jpeg});
    sent.image = image.frame;
  }
  return out.take();
}

std::string answer(const ViewState& state, std::string_view question) {
  const auto json = nlohmann::json::parse(question, nullptr, false);
  BlockWriter out;
  const auto id_in = [&](const char* name) {
    return json.is_object() && json.contains(name) && json[name].is_number_unsigned() &&
           json[name].get<uint64_t>() <= std::numeric_limits<uint32_t>::max();
  };
  if (id_in("key_frame")) {
    const auto id = json["key_frame"].get<uint32_t>();
    out.observations(Block::key_frame_observations, id, observations_of_key_frame(*state.map, id));
  } else if (id_in("point")) {
    const auto id = json["point"].get<uint32_t>();
    out.observations(Block::point_observations, id, observations_of_point(*state.map, id));
  }
  return out.take();
}

std::optional<std::chrono::milliseconds> interval_in(std::string_view question) {
  const auto json = nlohmann::json::parse(question, nullptr, false);
  if (!json.is_object() || !json.contains("interval") || !json["interval"].is_number_unsigned()) return {};
  return std::chrono::milliseconds(std::min(json["interval"].get<uint64_t>(), uint64_t{1} << 31));
}

std::string file_of(const ViewState& state) {
  Sent nothing;
  const MapScene& map = *state.map;
  BlockWriter observations;
  for (size_t k = 0; k + 1 < map.first_observation.size(); ++k) {
    const auto rows = std::span(map.observations)
                          .subspan(map.first_observation[k], map.first_observation[k + 1] - map.first_observation[k]);
    observations.observations(Block::key_frame_observations, map.key_frames[k].id, rows);
  }
  return std::string(kMagic) + message_since(state, nothing) + observations.take();
}

Result<ViewState> state_of_file(std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) return fail("it does not begin as such a file of this version does");
  const auto blocks = read_blocks(bytes.substr(kMagic.size()));
  if (!blocks) return tl::unexpected(blocks.error());
  ViewState state;
  MapScene map;
  std::vector<LoopPaths> loops;
  map.first_observation = {0};
  for (const ReadBlock& block : *blocks) {
    if (const auto read = read_block(block, map, loops, state); !read) return tl::unexpected(read.error());
  }
  if (!nlohmann::json::accept(state.info)) return fail("it does not say what it shows: it is cut short");
  if (auto known = check_cameras(map); !known) return tl::unexpected(known.error());
  map.first_observation.resize(map.key_frames.size() + 1, static_cast<uint32_t>(map.observations.size()));
  state.log.set_loops(loops);
  state.map = std::make_shared<const MapScene>(std::move(map));
  return state;
}

}  // namespace covis::view
