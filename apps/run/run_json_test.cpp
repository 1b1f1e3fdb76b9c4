// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/run/test_run.h"

namespace covis::app {
namespace {

using nlohmann::json;

std::vector<json> lines_of(const std::string& text) {
  std::vector<json> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(json::parse(line));
  return lines;
}

std::string stats_of(const RunRecord& run, const Snapshot& snapshot) {
  std::string text;
  FileSink sink(text);
  append_stats(run, snapshot, sink);
  return text;
}

TEST(RunJson, SummaryHasTheKeysThatScriptsRead) {
  const Snapshot snapshot = made_snapshot();
  const Trajectory truth = main_submap(snapshot).trajectory;
  const json s = to_json(summarise(made_record(), snapshot, &truth, 123));
  EXPECT_EQ(s["sensor"], "rgbd");
  EXPECT_EQ(s["frames"], 10);
  EXPECT_EQ(s["frames_tracked"], 6);
  EXPECT_EQ(s["frames_late"], 1);
  EXPECT_EQ(s["frames_dropped"], 0);
  EXPECT_EQ(s["camera_gone"], 0);
  EXPECT_FALSE(s.contains("failure"));
  EXPECT_EQ(s["map_points"], 42);
  EXPECT_EQ(s["camera"]["fx"], 500);
  EXPECT_EQ(s["camera_given"], json({{"fx", 500.0}, {"fy", 501.0}, {"cx", 320.0}, {"cy", 240.0}}));
  EXPECT_EQ(s["interrupted"], false);
  EXPECT_EQ(s["frame_ms"]["median"], 40);
  EXPECT_EQ(s["stage_ms"].size(), 9u);
  EXPECT_EQ(s["mapping_ms"].size(), 9u);
  EXPECT_EQ(s["maps"][1]["loaded"], true);
  EXPECT_EQ(s["not_tracked"][1], json({{"first", 5}, {"last", 6}, {"state", "lost"}, {"reason", "reason 5"}}));
  EXPECT_EQ(s["loops"], json::array());
  EXPECT_EQ(s["ate_alignment"], "se3");
  EXPECT_TRUE(s.contains("ate_sim3_m"));
  EXPECT_FALSE(to_json(summarise(made_record(), snapshot, nullptr, 0)).contains("ate_m"));
}

TEST(RunJson, TheCameraHasADistortionThatWasFound) {
  Snapshot snapshot = made_snapshot();
  EXPECT_FALSE(to_json(summarise(made_record(), snapshot, nullptr, 0))["camera"].contains("k1"));
  snapshot.camera.residual = {0.5, -0.25};
  const json camera = to_json(summarise(made_record(), snapshot, nullptr, 0))["camera"];
  EXPECT_EQ(camera["k1"], 0.5);
  EXPECT_EQ(camera["k2"], -0.25);
}

TEST(RunJson, WarningsHaveTheirFigure) {
  RunRecord run = made_record();
  EXPECT_EQ(to_json(summarise(run, made_snapshot(), nullptr, 0))["warnings"], json::array());
  run.warnings = {{SensorDoubt::depth_against_motion, 1.25, 8}};
  const json warning = to_json(summarise(run, made_snapshot(), nullptr, 0))["warnings"][0];
  EXPECT_EQ(warning["frame"], 8);
  EXPECT_EQ(warning["kind"], "depth_against_motion");
  EXPECT_EQ(warning["figure"], 1.25);
  EXPECT_NE(warning["text"].get<std::string>().find("1.25"), std::string::npos);
}

TEST(RunJson, EveryFrameHasALine) {
  RunRecord run = made_record();
  run.mapping.resize(2);
  run.mapping[0].frame = 2;
  run.mapping[1].frame = 8;
  run.mapping[1].counts.points_created = 17;
  const auto lines = lines_of(stats_of(run, made_snapshot()));
  ASSERT_EQ(lines.size(), 10u);
  for (size_t k = 0; k < lines.size(); ++k) {
    EXPECT_EQ(lines[k]["frame"], k);
    EXPECT_EQ(lines[k].contains("inliers"), k != 7) << "the late frame was not looked at";
    EXPECT_EQ(lines[k].contains("mapping"), k == 2 || k == 8);
    EXPECT_EQ(lines[k].contains("map"), lines[k]["state"] == "tracking");
    EXPECT_EQ(lines[k].contains("online"), k != 1 && lines[k]["state"] == "tracking") << "frame 1 got its pose later";
  }
  EXPECT_EQ(lines[8]["map"], 1);
  EXPECT_EQ(lines[8]["online"], json({{"submap", 3}, {"position_m", {8.0, 6.4, 0.0}}}));
  EXPECT_EQ(lines[8]["mapping"]["points_created"], 17);
  EXPECT_EQ(lines[8]["tracking_ms"], 78);
}

TEST(RunJson, ReasonsNeedNotBeUtf8) {
  RunRecord run = made_record();
  run.frames[7].reason = "\xff.png: it can't be read";
  EXPECT_EQ(lines_of(stats_of(run, {})).size(), 10u);
}

}  // namespace
}  // namespace covis::app
