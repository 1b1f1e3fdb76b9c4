// SPDX-License-Identifier: Apache-2.0
// For tests of the command: the files that a run leaves.
#pragma once

#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "command.h"

namespace covis {

using nlohmann::json;

inline const std::vector<std::string> kFiles{"trajectory.txt", "trajectory_online.txt", "keyframes.txt", "map.ply",
                                             "stats.jsonl",    "summary.json",          "report.html"};

inline json parsed(const fs::path& file) { return json::parse(text_of(file), nullptr, false); }

// One object a line.
inline std::vector<json> parsed_lines(const fs::path& file) {
  std::vector<json> lines;
  std::istringstream in(text_of(file));
  for (std::string line; std::getline(in, line);) lines.push_back(json::parse(line, nullptr, false));
  return lines;
}

inline int line_count(const fs::path& file) {
  const std::string text = text_of(file);
  int count = 0;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) count += !line.empty() && line[0] != '#';
  return count;
}

// Every file is there and whole, and they agree with each other. Returns the number of frames taken.
inline int expect_results(const fs::path& out) {
  for (const std::string& name : kFiles) EXPECT_TRUE(fs::exists(out / name)) << name;
  for (const auto& entry : fs::directory_iterator(out)) {
    EXPECT_THAT(entry.path().filename().string(), testing::Not(testing::HasSubstr("tmp"))) << "left behind";
  }
  const json summary = parsed(out / "summary.json");
  EXPECT_TRUE(summary.is_object());
  if (!summary.is_object()) return -1;
  for (const char* key : {"frames", "frames_tracked", "keyframes", "map_points", "tracking_ms", "peak_rss_mb"})
    EXPECT_TRUE(summary.contains(key)) << key;
  EXPECT_TRUE(summary["tracking_ms"].contains("median"));
  EXPECT_TRUE(summary["tracking_ms"].contains("p95"));
  EXPECT_EQ(line_count(out / "trajectory.txt"), summary["frames_tracked"].get<int>());
  EXPECT_EQ(line_count(out / "trajectory_online.txt"), summary["frames_tracked_online"].get<int>());
  EXPECT_EQ(line_count(out / "keyframes.txt"), summary["keyframes"].get<int>());

  const std::vector<json> stats = parsed_lines(out / "stats.jsonl");
  const int frames = summary["frames"].get<int>();
  EXPECT_EQ(static_cast<int>(stats.size()), frames);
  for (const json& line : stats) {
    EXPECT_TRUE(line.is_object());
    if (!line.is_object()) break;
    for (const char* key : {"frame", "stamp", "state", "reason"})
      EXPECT_TRUE(line.contains(key)) << key << " is missing in " << line;
    // Frames that came too late (a busy machine, in real time) were not processed.
    for (const char* key : {"inliers", "features", "ms"})
      EXPECT_EQ(line.contains(key), line["state"] != "late" && line["state"] != "unreadable") << key << " in " << line;
    EXPECT_EQ(line["state"] == "tracking", line["reason"] == "") << line;
  }
  EXPECT_THAT(text_of(out / "map.ply"),
              testing::HasSubstr("element vertex " + std::to_string(summary["map_points"].get<int>()) + "\n"));
  EXPECT_THAT(text_of(out / "report.html"), testing::HasSubstr("</html>"));
  return frames;
}

}  // namespace covis
