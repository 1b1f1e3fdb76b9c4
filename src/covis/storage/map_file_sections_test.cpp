// SPDX-License-Identifier: Apache-2.0
// The sections that only some map files have.
#include "covis/features/straightening.h"
#include "covis/map/anchors.h"
#include "covis/map/camera_change.h"
#include "covis/storage/map_anchors.h"
#include "covis/storage/map_cameras.h"
#include "covis/storage/map_file.h"
#include "covis/storage/map_file_layout.h"
#include "covis/storage/test_map_files.h"

namespace covis::storage {
namespace {

TEST_F(MapFile, PixelSizesAreInFilesOfSeveralCamerasAlone) {
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
  EXPECT_EQ(opened->minor(), kMapFileMinorWithCameras);
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

TEST_F(MapFile, TheRegistrationOfDepthIsKept) {
  MapState state = random_map(7, 60, 12).state();
  const MapHeader header = test_header();
  ASSERT_TRUE(save_map(file(), state, header));
  EXPECT_FALSE(SectionFile::open(file())->has(kRegistration));
  state.camera.registration = {1.1, 5, -3, 14, 0.5};
  ASSERT_TRUE(save_map(file(), state, header));
  auto opened = SectionFile::open(file());
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->minor(), kMapFileMinorWithRegistration);
  EXPECT_EQ(load_map(file())->map.camera(), state.camera);
  EXPECT_EQ(read_map_info(file())->camera.registration, state.camera.registration);
  const std::string bytes = *opened->read(kRegistration, "registration");
  const auto with = [&](const std::string& changed) { return with_section(*opened, kRegistration, changed); };
  expect_refused(with(bytes + "x"), "length");
  expect_refused(with(std::string(6, '\0') + "\xf0\x7f" + bytes.substr(8)), "registration of depth is not valid");
}

TEST_F(MapFile, TheRollingShutterIsKept) {
  MapState state = random_map(7, 60, 12).state();
  ASSERT_TRUE(save_map(file(), state, test_header()));
  EXPECT_FALSE(SectionFile::open(file())->has(kShutter));
  state.camera.row_time = -4e-5;
  ASSERT_TRUE(save_map(file(), state, test_header()));
  auto opened = SectionFile::open(file());
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->minor(), kMapFileMinorWithShutter);
  EXPECT_EQ(load_map(file())->map.camera(), state.camera);
  EXPECT_EQ(read_map_info(file())->camera.row_time, state.camera.row_time);
  const std::string bytes = *opened->read(kShutter, "rolling shutter");
  expect_refused(with_section(*opened, kShutter, bytes + "x"), "length");
  for (const char* end : {"\xf0\x7f", "\xf0\x3f"})  // infinite, and a second from row to row
    expect_refused(with_section(*opened, kShutter, std::string(6, '\0') + end), "rolling shutter is not valid");
}

TEST_F(MapFile, WhatRectificationLeftIsKept) {
  MapState state = random_map(7, 60, 12).state();
  ASSERT_TRUE(save_map(file(), state, test_header()));
  EXPECT_FALSE(SectionFile::open(file())->has(kRightColumns));
  state.camera.right_columns = {{0.1, 0.5, -0.2, 0, 1, -2, 0.3}};
  ASSERT_TRUE(save_map(file(), state, test_header()));
  auto opened = SectionFile::open(file());
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->minor(), kMapFileMinor);
  const auto loaded = load_map(file());
  EXPECT_EQ(loaded->map.camera(), state.camera);
  const Features& features = *loaded->map.at(loaded->map.key_frames().front()).features;
  ASSERT_TRUE(features.right_columns);
  EXPECT_EQ(*features.right_columns, state.camera.right_columns);
  EXPECT_EQ(read_map_info(file())->camera.right_columns, state.camera.right_columns);
  const std::string bytes = *opened->read(kRightColumns, "right columns");
  const auto with = [&](const std::string& changed) { return with_section(*opened, kRightColumns, changed); };
  expect_refused(with(bytes + "x"), "length");
  expect_refused(with(std::string(6, '\0') + "\xf0\x7f" + bytes.substr(8)), "right columns are not valid");
}

TEST_F(MapFile, ResidualDistortionsAreInFilesOfCamerasThatHaveOne) {
  MapState state = random_map(3, 60, 12).state();
  MapHeader header = test_header();
  header.camera.distortion = Distortion::none;
  header.camera.coefficients = {};
  ASSERT_TRUE(save_map(file(), state, header));
  EXPECT_FALSE(SectionFile::open(file())->has(kResiduals));
  state.camera.residual = {0.02, -0.01};
  ASSERT_TRUE(save_map(file(), state, header));
  const std::string bytes = read_file(file());
  auto opened = SectionFile::open(file());
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->minor(), kMapFileMinorWithResiduals);
  auto loaded = load_map(file());
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->map.camera(), state.camera);
  EXPECT_EQ(read_map_info(file())->camera, state.camera);
  for (const KeyFrameId& id : loaded->map.key_frames())
    EXPECT_TRUE(straight_for(*loaded->map.at(id).features, state.camera));
  ASSERT_TRUE(save_map(file(), loaded->map.state(), header));
  EXPECT_EQ(read_file(file()), bytes);
  const std::string residuals = *opened->read(kResiduals, "residuals");
  const auto with = [&](const std::string& changed) { return with_section(*opened, kResiduals, changed); };
  expect_refused(with(residuals + "x"), "length");
  expect_refused(with(std::string(6, '\0') + "\xf0\x7f" + residuals.substr(8)), "residual distortion is not valid");

  // Key frames of another camera keep what was found of theirs.
  MapState other = state;
  MapHeader wider = header;
  wider.camera.width += 100;
  ASSERT_TRUE(express_in(other, header.camera, {wider.camera, refined_camera()}));
  ASSERT_TRUE(save_map(file(), other, wider));
  loaded = load_map(file());
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_FALSE(loaded->map.camera().residual.any());
  EXPECT_EQ(other_cameras(loaded->map.state()), (std::vector<RefinedCamera>{{header.camera, state.camera}}));
}

TEST_F(MapFile, AnchorsAreInFilesOfMapsWithAlignedFeatures) {
  MapState state = random_map(3, 60, 12).state();
  const MapHeader header = test_header();
  ASSERT_TRUE(save_map(file(), state, header));
  EXPECT_FALSE(SectionFile::open(file())->has(kAnchors));
  const size_t last = state.key_frames.size() - 1;
  auto features = state.key_frames[last].features->for_key_frame();
  features->anchor.resize(features->x.size(), 0);
  features->anchor[7] = anchor_at(state.key_frames[0].serial, 2);
  state.key_frames[last].features = features;
  ASSERT_TRUE(save_map(file(), state, header));
  const std::string bytes = read_file(file());
  auto opened = SectionFile::open(file());
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->minor(), kMapFileMinorWithAnchors);
  const auto loaded = load_map(file());
  ASSERT_TRUE(loaded) << loaded.error().message;
  const MapState again = loaded->map.state();
  for (size_t k = 0; k < again.key_frames.size(); ++k)
    EXPECT_EQ(again.key_frames[k].features->anchor, state.key_frames[k].features->anchor) << k;
  ASSERT_TRUE(save_map(file(), again, header));
  EXPECT_EQ(read_file(file()), bytes);
  const std::string anchors = *opened->read(kAnchors, "anchors");
  const auto with = [&](const std::string& changed) { return with_section(*opened, kAnchors, changed); };
  expect_refused(with(anchors + "x"), "length");
  expect_refused(with("\2" + anchors.substr(1)), "neither yes nor no");
  const size_t first = last + 1;  // after the no of the others, and the yes of the last
  expect_refused(with(anchors.substr(0, first) + std::string(7, '\xff') + "\x7f" + anchors.substr(first + 8)),
                 "a serial that is not given yet");
}

}  // namespace
}  // namespace covis::storage
