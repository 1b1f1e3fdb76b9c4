// SPDX-License-Identifier: Apache-2.0
// Saved maps: nothing is lost, and nothing damaged is taken.
#include "covis/storage/map_file.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "covis/core/log.h"
#include "covis/core/test_folder.h"
#include "covis/storage/test_map_files.h"

namespace covis::storage {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

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
  const KeyFrameId gone = map.begin_submap(3, -7, random_pose(random), random_features(random, 10));
  map.erase_submap(map.at(gone).submap);
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
  EXPECT_EQ(info->camera, refined_camera());
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
