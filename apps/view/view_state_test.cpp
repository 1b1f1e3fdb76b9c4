// SPDX-License-Identifier: Apache-2.0
#include "apps/view/view_state.h"

#include <gmock/gmock.h>

#include <limits>
#include <map>

#include "apps/view/test_scene.h"

namespace covis::view {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

ViewState small_state() {
  ViewState state;
  state.info = R"({"title":"small"})";
  state.map = std::make_shared<const MapScene>(scene_of(small_snapshot()));
  FrameRow row;
  for (int32_t k = 0; k < 4; ++k) {
    row.frame = k;
    state.log.add(row, k == 2 ? "dark" : "");
  }
  LoopPaths loop;
  loop.before = loop.after = {{10, {1, 2, 3}}};
  state.log.set_loops({loop});
  return state;
}

// Blocks by kind.
std::map<Block, std::string_view> blocks_of(const std::string& message) {
  std::map<Block, std::string_view> blocks;
  const auto list = read_blocks(message);
  for (const ReadBlock& block : *list) blocks[block.kind] = block.body;
  return blocks;
}

TEST(ViewState, ANewClientGetsEverythingOnce) {
  const ViewState state = small_state();
  Sent sent;
  const std::string message = message_since(state, sent);
  std::vector<Block> kinds;
  for (const auto& [kind, body] : blocks_of(message)) kinds.push_back(kind);
  EXPECT_THAT(kinds, UnorderedElementsAre(Block::info, Block::key_frames, Block::points, Block::edges, Block::path,
                                          Block::frames, Block::texts, Block::loop));
  EXPECT_EQ(message_since(state, sent), "");
}

TEST(ViewState, OnlyChangesAreSent) {
  ViewState state = small_state();
  Sent sent;
  message_since(state, sent);
  Snapshot changed = small_snapshot();
  changed.points[0].position_w.x() += 1;
  changed.points.pop_back();
  changed.observations.pop_back();
  changed.edges.clear();
  state.map = std::make_shared<const MapScene>(scene_of(changed));
  state.log.add(FrameRow(), "dark");
  const std::string message = message_since(state, sent);
  const auto blocks = blocks_of(message);
  EXPECT_EQ(blocks.size(), 4u);
  EXPECT_EQ(blocks.at(Block::points).size(), sizeof(PointRow));
  EXPECT_EQ(blocks.at(Block::points_removed).size(), sizeof(uint32_t));
  EXPECT_EQ(blocks.at(Block::edges_removed).size(), 2 * sizeof(uint32_t));
  EXPECT_EQ(blocks.at(Block::frames).size(), sizeof(FrameRow));
}

TEST(ViewState, AClientThatMissedStatesGetsTheNewestAlone) {
  ViewState state = small_state();
  Sent sent;
  message_since(state, sent);
  for (int32_t k = 1; k < 4; ++k) {
    state.image.frame = k;
    state.image.jpeg = "image " + std::to_string(k);
  }
  const std::string message = message_since(state, sent);
  EXPECT_THAT(std::string(blocks_of(message).at(Block::image)), testing::EndsWith("image 3"));
}

TEST(ViewState, NewInfoBeginsTheLogAnew) {
  ViewState state = small_state();
  Sent sent;
  message_since(state, sent);
  ++state.info_version;
  const std::string message = message_since(state, sent);
  EXPECT_EQ(blocks_of(message).at(Block::frames).size(), 4 * sizeof(FrameRow));
  EXPECT_EQ(blocks_of(message).count(Block::loop), 1u);
  EXPECT_EQ(blocks_of(message).count(Block::points), 0u);
}

TEST(ViewState, AFileIsTheState) {
  const ViewState state = small_state();
  const std::string file = file_of(state);
  const auto read = state_of_file(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->info, state.info);
  EXPECT_EQ(read->map->points, state.map->points);
  EXPECT_EQ(read->map->observations, state.map->observations);
  EXPECT_EQ(read->map->first_observation, state.map->first_observation);
  EXPECT_EQ(read->log.frames(), state.log.frames());
  EXPECT_EQ(read->log.texts(), state.log.texts());
  EXPECT_EQ(read->log.loops().front().after, state.log.loops().front().after);
  EXPECT_EQ(file_of(*read), file);
}

TEST(ViewState, DamagedFilesAreErrors) {
  const std::string file = file_of(small_state());
  EXPECT_FALSE(state_of_file(""));
  EXPECT_FALSE(state_of_file("COVISVW9"));
  EXPECT_FALSE(state_of_file(file.substr(0, file.size() - 4)));
  BlockWriter unknown;
  unknown.text(static_cast<Block>(99), "x");
  EXPECT_FALSE(state_of_file("COVISVW1" + unknown.take()));
}

ViewState state_of_two_cameras() {
  ViewState state = small_state();
  MapScene map = *state.map;
  map.cameras = {{900, 901, 640, 360, 1280, 720}};
  map.key_frames[1].camera = 1;
  state.map = std::make_shared<const MapScene>(std::move(map));
  return state;
}

TEST(ViewState, TheListOfCamerasIsSentWhenItChanges) {
  ViewState state = small_state();
  Sent sent;
  message_since(state, sent);
  state.map = state_of_two_cameras().map;
  const std::string message = message_since(state, sent);
  EXPECT_EQ(blocks_of(message).at(Block::cameras).size(), sizeof(CameraRow));
  EXPECT_EQ(blocks_of(message).at(Block::key_frames).size(), sizeof(KeyFrameRow));
  state.log.add(FrameRow(), "");
  EXPECT_EQ(blocks_of(message_since(state, sent)).count(Block::cameras), 0u);
}

TEST(ViewState, AFileHasTheCamerasThatItsKeyFramesName) {
  const ViewState state = state_of_two_cameras();
  const auto read = state_of_file(file_of(state));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->map->cameras, state.map->cameras);
  EXPECT_EQ(read->map->key_frames, state.map->key_frames);
  const auto problem = [&](auto change) {
    ViewState changed = state;
    MapScene map = *state.map;
    change(map);
    changed.map = std::make_shared<const MapScene>(std::move(map));
    const auto damaged = state_of_file(file_of(changed));
    return damaged ? std::string() : damaged.error().message;
  };
  EXPECT_THAT(problem([](MapScene& map) { map.key_frames[1].camera = 2; }), HasSubstr("key frame 15 is of camera 2"));
  EXPECT_THAT(problem([](MapScene& map) { map.cameras[0].width = 0; }), HasSubstr("no focal length or no size"));
}

// The page would show nothing at all.
TEST(ViewState, AFileWithANumberThatIsNotFiniteIsAnError) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const auto problem = [](auto change) {
    ViewState state = small_state();
    MapScene map = *state.map;
    change(map, state.log);
    state.map = std::make_shared<const MapScene>(std::move(map));
    const auto read = state_of_file(file_of(state));
    return read ? std::string() : read.error().message;
  };
  EXPECT_EQ(problem([](MapScene&, RunLog&) {}), "");
  EXPECT_THAT(problem([](MapScene& map, RunLog&) { map.points.back().position[1] = kNan; }), HasSubstr("not finite"));
  EXPECT_THAT(problem([](MapScene& map, RunLog&) { map.path.front().pose.q[2] = kNan; }), HasSubstr("not finite"));
  EXPECT_THAT(problem([](MapScene& map, RunLog&) { map.key_frames.front().pose.t[0] = kNan; }),
              HasSubstr("not finite"));
  FrameRow frame;
  frame.stamp = kNan;
  EXPECT_THAT(problem([&](MapScene&, RunLog& log) { log.add_row(frame); }), HasSubstr("not finite"));
  LoopPaths loop;
  loop.after = {{10, {1, kNan, 3}}};
  EXPECT_THAT(problem([&](MapScene&, RunLog& log) { log.set_loops({loop}); }), HasSubstr("not finite"));
}

TEST(ViewState, QuestionsAreAnswered) {
  const ViewState state = small_state();
  const std::string of_key_frame = answer(state, R"({"key_frame":15})"), of_point = answer(state, R"({"point":2})");
  uint32_t id = 0;
  EXPECT_EQ(read_blocks(of_key_frame)->front().observations(id)->size(), 2u);
  EXPECT_EQ(id, 15u);
  EXPECT_EQ(read_blocks(of_point)->front().observations(id)->size(), 2u);
  for (const char* nonsense : {"", "{", "[]", "{}", R"({"point":"2"})", R"({"point":-2})", "3"})
    EXPECT_EQ(answer(state, nonsense), "") << nonsense;
}

TEST(ViewState, APageAsksForAnInterval) {
  EXPECT_EQ(interval_in(R"({"interval":2000})"), std::chrono::milliseconds(2000));
  for (const char* another :
       {"", "[]", R"({"point":2})", R"({"interval":-1})", R"({"interval":"2"})", R"({"interval":0.5})"})
    EXPECT_FALSE(interval_in(another)) << another;
}

}  // namespace
}  // namespace covis::view
