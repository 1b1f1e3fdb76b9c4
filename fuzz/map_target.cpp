// SPDX-License-Identifier: Apache-2.0
// Map files. `map` takes the sections as they are before compression, and packs them: what the reader sees has right
// checksums. `map_container` takes a file's bytes, and mends its checksums.
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "covis/core/random.h"
#include "covis/features/test_features.h"
#include "covis/map/camera_change.h"
#include "covis/storage/map_file.h"
#include "covis/storage/test_sections.h"
#include "scratch.h"
#include "target.h"

namespace covis::fuzz {
namespace {

using namespace storage;

constexpr size_t kHeader = 32, kEntry = 24;

void load(std::string_view file) {
  const MemoryFile memory(file);
  static_cast<void>(read_map_info(memory.path()));
  const auto loaded = load_map(memory.path());
  if (!loaded) return;
  require(loaded->map.check().empty(), "a loaded map is sound");
  require(Map::from_state(loaded->map.state()).has_value(), "a loaded map can be taken apart and put together");
}

// The input: for each section its id (a byte), its length (four bytes), its bytes.
void run_map(std::string_view bytes) {
  std::vector<Section> sections;
  while (bytes.size() >= 5 && sections.size() < 16) {
    uint32_t length = 0;
    const auto id = static_cast<uint8_t>(bytes[0]);
    std::memcpy(&length, bytes.data() + 1, sizeof length);
    bytes.remove_prefix(5);
    sections.push_back({id, std::string(bytes.substr(0, length))});
    bytes.remove_prefix(std::min<size_t>(length, bytes.size()));
  }
  const auto file = pack_sections(std::move(sections));
  if (file) load(*file);
}

template <class T>
T number_at(const std::string& bytes, size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

template <class T>
void put(std::string& bytes, size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

void run_container(std::string_view given) {
  std::string file(given);
  if (file.size() >= kHeader) {
    std::memcpy(file.data(), "COVISMAP", 8);
    put(file, 8, kMapFileMajor);
    put(file, 16, uint64_t{file.size()});
    const size_t count = std::min<size_t>(number_at<uint32_t>(file, 12), (file.size() - kHeader) / kEntry);
    size_t offset = kHeader + kEntry * count;
    for (size_t i = 0; i < count; ++i) {
      const size_t entry = kHeader + kEntry * i;
      const size_t stored = std::min<uint64_t>(number_at<uint64_t>(file, entry + 8), file.size() - offset);
      put(file, entry + 4, crc32(std::string_view(file).substr(offset, stored)));
      offset += stored;
    }
    const std::string_view view(file);
    put(file, 28, crc32(view.substr(kHeader, kEntry * count), crc32(view.substr(0, 28))));
  }
  load(file);
}

FeaturesPtr seed_features(Random& random, int count) {
  auto f = std::make_shared<Features>(no_features());
  for (int i = 0; i < count; ++i) {
    add(*f, {random.uniform(0, 640), random.uniform(0, 480), static_cast<int>(random.below(8)),
             random_descriptor(random), random.uniform(0, 6), random.below(2) * random.uniform(1, 9)});
  }
  finish(*f, {0, 0, 640, 480});
  return f;
}

enum class Cameras { one, several };

std::string seed_map(int key_frames, bool coloured, Cameras cameras = Cameras::one) {
  Random random(7);
  Map map;
  map.set_camera({500, 500, 320, 240, 40});
  for (int i = 0; i < key_frames; ++i) {
    const SE3 pose(Eigen::Matrix3d::Identity(), {0.1 * i, 0, 0});
    const FeaturesPtr features = seed_features(random, 6);
    const KeyFrameId id = i == 3 ? map.begin_submap(i, i, pose, features) : map.add_key_frame(i, i, pose, features);
    if (i == 0) {
      for (uint32_t f = 0; f < 4; ++f) map.add_point({0, 0.1 * f, 3}, id, f);
    } else if (i < 3) {
      for (uint32_t f = 0; f < 4; ++f) map.add_observation(map.points()[f], id, f);
    }
    map.attach_to_tree(id);
    if (coloured) map.set_colours(id, std::make_shared<const std::vector<Colour>>(6, Colour{1, 2, 3}));
  }
  if (key_frames > 2) map.add_loop_edge(map.key_frames()[0], map.key_frames()[2]);
  MapHeader header;
  header.camera = {640, 480, {500, 500, 320, 240, 40}, Distortion::brown_conrady, {0.1, 0, 0, 0, 0}};
  header.sensor = Sensor::rgbd;
  header.levels = 8;
  header.factor = 1.2f;
  header.vocabulary = "0123456789abcdef";
  const std::filesystem::path file = scratch_folder() / "seed.covis";
  MapState state = map.state();
  if (cameras == Cameras::several) {
    RefinedCamera other{header.camera, {250, 250, 160, 120, 20}};
    other.given.width = 320;
    require(express_in(state, header.camera, other).has_value(), "a seed can be expressed in another camera");
    state.key_frames.front().features = map.at(map.key_frames().front()).features;
    header.camera = other.given;
  }
  require(save_map(file, state, header).has_value(), "a seed can be saved");
  auto opened = SectionFile::open(file);
  std::string input;
  for (const uint8_t id : {1, 2, 3, 4, 5, 6, 7, 8, 9}) {
    if (!opened->has(id)) continue;
    const std::string section = *opened->read(id, "any");
    const auto length = static_cast<uint32_t>(section.size());
    input.push_back(static_cast<char>(id));
    input.append(reinterpret_cast<const char*>(&length), sizeof length);
    input += section;
  }
  return input;
}

std::vector<std::string> map_seeds() {
  return {seed_map(0, false), seed_map(2, true), seed_map(5, false), seed_map(4, false, Cameras::several)};
}

std::vector<std::string> container_seeds() {
  return {*pack_sections({{1, "about"}, {2, std::string(100, 'x')}, {77, ""}}), *pack_sections({})};
}

}  // namespace

std::vector<Target> map_targets() {
  return {{"map", run_map, map_seeds}, {"map_container", run_container, container_seeds}};
}

}  // namespace covis::fuzz
