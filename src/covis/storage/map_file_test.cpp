// SPDX-License-Identifier: Apache-2.0
// Saved maps: nothing is lost, and nothing damaged is taken.
#include "covis/storage/map_file.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "covis/core/log.h"
#include "covis/core/test_folder.h"
#include "covis/map/camera_change.h"
#include "covis/storage/map_cameras.h"
#include "covis/storage/test_maps.h"
#include "covis/storage/test_sections.h"

namespace covis::storage {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class MapFile : public testing::Test {
 protected:
  const TemporaryFolder folder;
  fs::path file() const { return folder / "m.covis"; }
  std::string bytes_of(const Map& map) const {
    const auto saved = save_map(file(), map.state(), test_header());
    EXPECT_TRUE(saved) << saved.error().message;
    return read_file(file());
  }
  // The file's bytes with one section after `change`, the checksums right again.
  std::string with_changed(uint32_t id, const std::function<void(std::string&)>& change) const {
    auto opened = SectionFile::open(file());
    std::vector<Section> sections;
    for (uint32_t i = 1; i <= 5; ++i) sections.push_back({i, *opened->read(i, "any")});
    change(sections[id - 1].bytes);
    return *pack_sections(sections);
  }
  // Loading and asking fail, the message names the file and says so.
  void expect_refused(const std::string& bytes, const std::string& why) const {
    write_file(folder / "bad.covis", bytes);
    const auto loaded = load_map(folder / "bad.covis");
    ASSERT_FALSE(loaded);
    EXPECT_THAT(loaded.error().message, testing::StartsWith((folder / "bad.covis").string() + ": "));
    EXPECT_THAT(loaded.error().message, HasSubstr(why));
  }
};

TEST_F(MapFile, LoadedMapEqualsTheSavedOneAndSavesTheSameBytes) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    const Map map = random_map(seed, 100 * static_cast<int>(seed));
    ASSERT_EQ(map.check(), "");
    const std::string bytes = bytes_of(map);
    const auto loaded = load_map(file());
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(loaded->map.check(), "");
    expect_equal(map, loaded->map);
    EXPECT_EQ(bytes_of(loaded->map), bytes);
  }
}

TEST_F(MapFile, RawPixelsAreInTheFileAndKeptOnlyWhereTheyDiffer) {
  Random random(5);
  for (const bool differ : {false, true}) {
    auto features = std::make_shared<Features>(*random_features(random, 40));
    features->raw_x = features->x;
    features->raw_y = features->y;
    if (differ) features->raw_y[17] += 0.5f;
    Map map;
    map.set_camera(refined_camera());
    map.begin_submap(0, 0, SE3(), features);
    const std::string bytes = bytes_of(map);
    const auto loaded = load_map(file());
    ASSERT_TRUE(loaded) << loaded.error().message;
    const Features& read = *loaded->map.at(loaded->map.root()).features;
    EXPECT_EQ(read.raw_x.capacity() + read.raw_y.capacity(), differ ? 80u : 0u);
    EXPECT_EQ(read.image_x(), features->raw_x);
    EXPECT_EQ(read.image_y(), features->raw_y);
    EXPECT_EQ(bytes_of(loaded->map), bytes);
  }
}

TEST_F(MapFile, EmptyMapAndSmallMaps) {
  Map map;
  const std::string empty = bytes_of(map);
  EXPECT_EQ(load_map(file())->map.camera(), test_header().camera.pinhole) << "nothing refined";
  map.set_camera(refined_camera());
  EXPECT_EQ(load_map(file())->map.key_frame_count(), 0u);
  EXPECT_EQ(bytes_of(load_map(file())->map), empty);
  Random random(1);
  // Erased things leave serials behind.
  map.add_key_frame(3, -7, random_pose(random), random_features(random, 10));
  map.clear();
  bytes_of(map);
  EXPECT_EQ(load_map(file())->map.next_serial(), 1u);
  const KeyFrameId k =
      map.add_key_frame(std::numeric_limits<int64_t>::min(), 1 - (int64_t{1} << 62), SE3(), random_features(random, 0));
  const std::string one = bytes_of(map);
  const auto loaded = load_map(file());
  ASSERT_TRUE(loaded) << loaded.error().message;
  expect_equal(map, loaded->map);
  EXPECT_EQ(bytes_of(loaded->map), one);
  EXPECT_EQ(map.at(k).serial, 1u);
}

// Older files have a key frame's serial there.
TEST_F(MapFile, TheReservedFieldOfAPointIsNotLookedAt) {
  constexpr size_t kRecord = 104, kReserved = 92;  // bytes
  const Map map = random_map(3, 300);
  const std::string bytes = bytes_of(map);
  const std::string older = with_changed(5, [](std::string& points) {
    for (size_t at = kReserved; at < points.size(); at += kRecord) {
      EXPECT_EQ(points.substr(at, 4), std::string(4, '\0'));
      points[at] = 7;
    }
  });
  EXPECT_NE(older, bytes);
  write_file(file(), older);
  const auto loaded = load_map(file());
  ASSERT_TRUE(loaded) << loaded.error().message;
  expect_equal(map, loaded->map);
  EXPECT_EQ(bytes_of(loaded->map), bytes);
}

TEST_F(MapFile, LoadedMapGoesOn) {
  const Map map = random_map(3, 700);
  bytes_of(map);
  auto loaded = load_map(file());
  ASSERT_TRUE(loaded);
  Map& on = loaded->map;
  Random random(4);
  const KeyFrameId k = on.add_key_frame(9, 9, SE3(), random_features(random, 30));
  EXPECT_EQ(on.at(k).serial, map.next_serial());
  for (uint32_t f = 0; f < 10; ++f) on.add_observation(on.points()[f], k, f);
  on.attach_to_tree(k);
  EXPECT_EQ(on.check(), "");
  for (const KeyFrameId& id : on.key_frames()) {
    on.erase_key_frame(id);
    ASSERT_EQ(on.check(), "");
  }
  EXPECT_EQ(on.key_frame_count(), on.submaps().size()) << "roots stay";
}

// Early versions could leave key frames of two cameras in a map.
TEST_F(MapFile, KeyFramesOfTwoCamerasGetTheFirstOnes) {
  bytes_of(random_map(3, 300));
  // The camera of the last key frame (fx, …) precedes its bounds, pyramid and loop edges. It is found by its bytes.
  const std::string changed = with_changed(2, [](std::string& bytes) {
    const double fx = refined_camera().fx, other = fx + 3;
    const size_t at = bytes.rfind(std::string(reinterpret_cast<const char*>(&fx), sizeof fx));
    ASSERT_NE(at, std::string::npos);
    bytes.replace(at, sizeof other, reinterpret_cast<const char*>(&other), sizeof other);
  });
  write_file(folder / "two.covis", changed);
  std::string said;
  set_log_sink([&](LogLevel, std::string_view text) { said += text; });
  const auto loaded = load_map(folder / "two.covis");
  set_log_sink({});
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->map.camera(), refined_camera());
  EXPECT_THAT(said, HasSubstr("several cameras"));
}

TEST_F(MapFile, InfoSaysWhatIsInIt) {
  Map map;
  map.set_camera(refined_camera());
  Random random(1);
  const auto at = [](double x, double y, double z) {
    return SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-x, -y, -z));
  };
  const KeyFrameId a = map.add_key_frame(0, from_seconds(10), at(1, 2, 3), random_features(random, 20));
  const KeyFrameId b = map.add_key_frame(5, from_seconds(12.5), at(4, 2, 1), random_features(random, 15));
  map.add_observation(map.add_point({0, 0, 5}, a, 3), b, 4);
  map.add_point({0, 1, 5}, a, 4);
  map.attach_to_tree(b);
  const std::string bytes = bytes_of(map);
  const auto info = read_map_info(file());
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->key_frames, 2u);
  EXPECT_EQ(info->points, 2u);
  EXPECT_EQ(info->observations, 3u);
  EXPECT_EQ(info->features, 35u);
  EXPECT_EQ(info->file_size, bytes.size());
  EXPECT_EQ(info->major, kMapFileMajor);
  EXPECT_DOUBLE_EQ(info->seconds, 2.5);
  EXPECT_TRUE(info->extent.isApprox(Eigen::Vector3d(3, 0, 2)));
  for (const MapHeader& h : {info->header, load_map(file())->header}) {
    EXPECT_EQ(h.camera.width, 640);
    EXPECT_EQ(h.camera.height, 480);
    EXPECT_EQ(h.camera.pinhole.fy, 501);
    EXPECT_EQ(h.camera.pinhole.bf, 40);
    EXPECT_EQ(h.camera.distortion, Distortion::brown_conrady);
    EXPECT_EQ(h.camera.coefficients, test_header().camera.coefficients);
    EXPECT_EQ(h.sensor, Sensor::rgbd);
    EXPECT_EQ(h.levels, 8);
    EXPECT_EQ(h.factor, 1.2f);
    EXPECT_EQ(h.vocabulary, "0123456789abcdef");
  }
}

// The sections that every file has, and another one.
std::string with_section(SectionFile& opened, uint32_t id, const std::string& bytes) {
  std::vector<Section> sections;
  for (uint32_t i = 1; i <= 5; ++i) sections.push_back({i, *opened.read(i, "any")});
  sections.push_back({id, bytes});
  return *pack_sections(sections);
}

TEST_F(MapFile, PixelSizesAreInFilesOfSeveralCamerasAlone) {
  constexpr uint32_t kPixelSizes = 8;
  MapState state = random_map(3, 60, 12).state();
  Pinhole other = state.camera;
  other.fx *= 2;
  other.fy *= 2;
  MapHeader header = test_header();
  ASSERT_TRUE(express_in(state, header.camera, {header.camera, other}));
  header.camera.pinhole = other;
  // Files of version 1.4 did not name cameras.
  for (KeyFrameState& k : state.key_frames) {
    auto unnamed = k.features->for_key_frame();
    unnamed->made_by = nullptr;
    k.features = unnamed;
  }
  ASSERT_TRUE(save_map(file(), state, header));
  auto opened = SectionFile::open(file());
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->minor(), kMapFileMinorWithSizes);
  const auto loaded = load_map(file());
  ASSERT_TRUE(loaded) << loaded.error().message;
  for (const KeyFrameId& id : loaded->map.key_frames()) EXPECT_EQ(loaded->map.at(id).features->pyramid->base, 2);
  const std::string sizes = *opened->read(kPixelSizes, "sizes");
  const auto with = [&](const std::string& bytes) { return with_section(*opened, kPixelSizes, bytes); };
  expect_refused(with(sizes + "x"), "length");
  expect_refused(with(std::string(sizes.size(), '\0')), "no valid size of its pixels");
  expect_refused(with(std::string(sizes.size(), '\xff')), "no valid size of its pixels");
}

TEST_F(MapFile, CamerasOfKeyFramesAreInFilesOfSeveralAlone) {
  MapState state = random_map(3, 60, 12).state();
  const MapHeader made_by = test_header();
  MapHeader header = made_by;
  header.camera.distortion = Distortion::none;
  header.camera.width += 100;
  const Pinhole before = state.camera;
  ASSERT_TRUE(express_in(state, made_by.camera, {header.camera, before}));  // another lens, pixels of the same size
  ASSERT_TRUE(save_map(file(), state, header));
  const std::string bytes = read_file(file());
  auto opened = SectionFile::open(file());
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->minor(), kMapFileMinor);
  auto loaded = load_map(file());
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(other_cameras(loaded->map.state()), (std::vector<RefinedCamera>{{made_by.camera, before}}));
  ASSERT_TRUE(save_map(file(), loaded->map.state(), header));
  EXPECT_EQ(read_file(file()), bytes);
  const auto info = read_map_info(file());
  ASSERT_TRUE(info) << info.error().message;
  ASSERT_EQ(info->other_cameras.size(), 1u);
  EXPECT_EQ(info->other_cameras[0].given, made_by.camera);
  EXPECT_EQ(info->other_cameras[0].key_frames, info->key_frames);
  const std::string cameras = *opened->read(kCameras, "cameras");
  const auto with = [&](const std::string& changed) { return with_section(*opened, kCameras, changed); };
  expect_refused(with(cameras + "x"), "length");
  expect_refused(with(cameras.substr(0, cameras.size() - 1) + '\x7f'), "a camera that is not there");
  expect_refused(with(std::string(4, '\xff') + cameras.substr(4)), "more than a map can have");
  const size_t camera = (cameras.size() - 4 - 4 * state.key_frames.size());
  expect_refused(with(std::string("\2\0\0\0", 4) + cameras.substr(4, camera) + cameras.substr(4)), "made no key frame");
  expect_refused(with(cameras.substr(0, 4) + std::string(8, '\0') + cameras.substr(12)),
                 "a key frame's camera: its camera has no image size");
}

TEST_F(MapFile, ColoursAreInFilesOfColouredMapsAlone) {
  constexpr uint32_t kColours = 7;
  bytes_of(random_map(3, 60, 12));
  EXPECT_FALSE(SectionFile::open(file())->has(kColours));
  EXPECT_EQ(SectionFile::open(file())->minor(), kMapFileMinorLeast) << "earlier versions know all of it";
  bytes_of(random_map(4, 60, 12));
  auto opened = SectionFile::open(file());
  EXPECT_EQ(opened->minor(), kMapFileMinorWithColours);
  std::vector<Section> sections;
  for (uint32_t i = 1; i <= 5; ++i) sections.push_back({i, *opened->read(i, "any")});
  const std::string colours = *opened->read(kColours, "colours");
  const auto with = [&](std::string bytes) {
    std::vector<Section> all = sections;
    all.push_back({kColours, std::move(bytes)});
    return *pack_sections(all);
  };
  write_file(folder / "same.covis", with(colours));
  EXPECT_TRUE(load_map(folder / "same.covis"));
  expect_refused(with(colours + "x"), "length");
  expect_refused(with(colours.substr(1)), "");
  expect_refused(with("\2" + colours.substr(1)), "neither yes nor no");
}

TEST_F(MapFile, TheNoiseOfDepthIsKept) {
  Map map = random_map(7, 60, 12);
  bytes_of(map);
  EXPECT_FALSE(SectionFile::open(file())->has(6)) << "of other sensors there is none to keep";
  Pinhole camera = refined_camera();
  camera.depth_noise = {0.0005, 0.0012};
  map.set_camera(camera);
  bytes_of(map);
  EXPECT_TRUE(SectionFile::open(file())->has(6));
  EXPECT_EQ(load_map(file())->map.camera(), camera);
}

TEST_F(MapFile, CutOffAtAnyLength) {
  const std::string bytes = bytes_of(random_map(1, 60, 12));
  for (size_t length = 0; length < bytes.size(); length += length < 400 ? 1 : 41) {
    expect_refused(bytes.substr(0, length), "");
    EXPECT_FALSE(read_map_info(folder / "bad.covis"));
  }
  expect_refused(bytes + "x", "damaged");
}

TEST_F(MapFile, AnyFlippedByteIsTold) {
  std::string bytes = bytes_of(random_map(2, 60, 12));
  Random random(5);
  for (size_t at = 0; at < bytes.size(); at += at < 160 ? 1 : 1 + random.below(64)) {
    const char before = bytes[at];
    bytes[at] = static_cast<char>(before ^ static_cast<char>(1 + random.below(255)));
    expect_refused(bytes, "");
    bytes[at] = before;
  }
  bytes[bytes.size() / 2] = static_cast<char>(~bytes[bytes.size() / 2]);
  expect_refused(bytes, "damaged: the checksum of its section 'features' is wrong");
}

TEST_F(MapFile, ForeignMissingAndEmptyFiles) {
  expect_refused("", "it is empty");
  expect_refused("COVIS", "it is not a map of Covis");
  expect_refused("%YAML:1.0\n", "it is not a map of Covis");
  expect_refused(std::string(5000, '\0'), "it is not a map of Covis");
  expect_refused("COVISMAP", "it is cut off within its header");
  EXPECT_THAT(load_map(folder / "none.covis").error().message, HasSubstr("none.covis: it can't be opened"));
  EXPECT_THAT(load_map(folder.path()).error().message, HasSubstr("it is a folder"));
  EXPECT_THAT(save_map(folder / "no/m.covis", Map().state(), test_header()).error().message, HasSubstr("no/m.covis"));
}

TEST_F(MapFile, NewerVersions) {
  const Map map = random_map(5, 300);
  bytes_of(map);
  auto opened = SectionFile::open(file());
  std::vector<Section> sections{{77, "what nobody knew in the year of this version"}};
  for (uint32_t i = 1; i <= 5; ++i) sections.push_back({i, *opened->read(i, "any")});
  sections.push_back({78, ""});
  std::string newer = *pack_sections(sections, kMapFileMajor, kMapFileMinor + 3);
  write_file(folder / "newer.covis", newer);
  const auto loaded = load_map(folder / "newer.covis");
  ASSERT_TRUE(loaded) << loaded.error().message;
  expect_equal(map, loaded->map);
  EXPECT_EQ(read_map_info(folder / "newer.covis")->minor, kMapFileMinor + 3);
  newer[32 + 7 * 24] = static_cast<char>(~newer[32 + 7 * 24]);  // the first byte of the unknown section
  expect_refused(newer, "section '77'");
  expect_refused(*pack_sections(sections, kMapFileMajor + 1, 0), "it is of version 2.0 of the map format");
  sections.pop_back();
  sections.pop_back();
  expect_refused(*pack_sections(sections), "it has no section 'points'");
}

// Wrong contents with valid checksums. Every outcome other than a sound map or an error is a crash.
TEST_F(MapFile, WrongContentsAreNeverTrusted) {
  bytes_of(random_map(7, 150, 12));
  Random random(8);
  int refused = 0;
  constexpr int kRounds = 800;
  for (int round = 0; round < kRounds; ++round) {
    write_file(folder / "bad.covis", with_changed(1 + random.below(5), [&](std::string& bytes) {
                 const uint32_t size = static_cast<uint32_t>(bytes.size());
                 if (random.below(20) == 0) {
                   bytes.resize(random.below(2 * size));
                 } else {
                   const char values[] = {'\xff', '\0', '\x7f', static_cast<char>(random.below(256))};
                   const uint32_t at = random.below(size), length = 1 + random.below(8);
                   for (uint32_t i = at; i < std::min(at + length, size); ++i) bytes[i] = values[random.below(4)];
                 }
               }));
    const auto loaded = load_map(folder / "bad.covis");
    refused += !loaded;
    if (loaded) {
      ASSERT_EQ(loaded->map.check(), "");
    } else {
      ASSERT_THAT(loaded.error().message, HasSubstr("bad.covis: "));
    }
    static_cast<void>(read_map_info(folder / "bad.covis"));
  }
  EXPECT_GT(refused, kRounds / 10);
}

}  // namespace
}  // namespace covis::storage
