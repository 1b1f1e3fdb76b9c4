// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_text.h"

#include <gtest/gtest.h>

#include "apps/run/run_json.h"
#include "apps/run/test_run.h"

namespace covis::app {
namespace {

TEST(RunText, SaysTheMainFigures) {
  Snapshot snapshot = made_snapshot();
  const Trajectory truth = main_submap(snapshot).trajectory;
  EXPECT_EQ(summary_text(summarise(made_record(), snapshot, nullptr, 123), "out"),
            "6 of 10 frames tracked, 3 key frames, 42 points\n"
            "2 maps that could not be joined; trajectory.txt has the 4 frames of the first\n"
            "tracking 38.00 ms a frame (median), 88.00 ms (95 %); 2.0 frames/s in all; peak memory 123 MB\n"
            "written to out\n");
  snapshot.submaps.pop_back();
  const std::string text = summary_text(summarise(made_record(), snapshot, &truth, 123), "out");
  EXPECT_EQ(text.find("joined"), std::string::npos);
  EXPECT_NE(text.find("error (ATE RMSE): 0.0000 m after se3 alignment, over 3."), std::string::npos) << text;
}

TEST(RunText, TellsTheFocalLengthWhereTheMapMovedIt) {
  Snapshot snapshot = made_snapshot();
  snapshot.camera.fx = 507.5;
  const RunSummary summary = summarise(made_record(), snapshot, nullptr, 0);
  EXPECT_NE(summary_text(summary, "out").find("focal length refined: 507.5 pixels instead of 500.0\n"),
            std::string::npos);
  const auto rows = summary_rows(summary);
  ASSERT_EQ(rows.size(), 9u);
  EXPECT_EQ(rows.back(), std::pair(std::string("focal length, refined"), std::string("507.5 pixels instead of 500.0")));
}

TEST(RunText, TellsTheDistortionThatWasFound) {
  Snapshot snapshot = made_snapshot();
  snapshot.camera.residual = {0.02314, -0.0109};
  const RunSummary summary = summarise(made_record(), snapshot, nullptr, 0);
  EXPECT_NE(summary_text(summary, "out").find("distortion found: k1 0.0231, k2 -0.0109, where none was given\n"),
            std::string::npos);
  const auto row = summary_rows(summary).back();
  EXPECT_EQ(row,
            std::pair(std::string("distortion found"), std::string("k1 0.0231, k2 -0.0109, where none was given")));
}

TEST(RunText, TellsTheRegistrationThatWasFound) {
  Snapshot snapshot = made_snapshot();
  snapshot.camera.registration = {1.107, 5.5, 3, 0, 0};
  RunSummary summary = summarise(made_record(), snapshot, nullptr, 0);
  const std::string said = "1.1070 times as large, moved by 5.5 and 3.0 pixels, and by 0.0 and 0.0 at a metre";
  EXPECT_NE(summary_text(summary, "out").find("depth images are not registered to the images: " + said + "\n"),
            std::string::npos);
  EXPECT_EQ(summary_rows(summary).back().second, said);
  summary.given.registration = summary.camera.registration;
  EXPECT_EQ(summary_text(summary, "out").find("registered"), std::string::npos) << "it was given";
  summary.camera.registration = {};
  EXPECT_EQ(summary_text(summary, "out").find("registered"), std::string::npos) << "of a sensor without depth";
}

TEST(RunText, TellsTheRollingShutterThatWasFound) {
  Snapshot snapshot = made_snapshot();
  snapshot.camera.row_time = 0.02051 / 480;
  RunRecord record = made_record();
  record.image_height = 480;
  RunSummary summary = summarise(record, snapshot, nullptr, 0);
  const std::string said = "0.0205 seconds from the first row to the last";
  EXPECT_NE(summary_text(summary, "out").find("rolling shutter found: " + said + " (readout)\n"), std::string::npos);
  EXPECT_EQ(summary_rows(summary).back().second, said);
  EXPECT_NEAR(to_json(summary)["camera"]["readout"].get<double>(), 0.02051, 1e-9);
  summary.given.row_time = summary.camera.row_time;
  EXPECT_EQ(summary_text(summary, "out").find("shutter"), std::string::npos) << "it was given";
}

TEST(RunText, ARunWithoutAPoseIsExplainedByItsCameraElseByItsFrames) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.pinhole = {500, 500, 320, 240, 0};
  RunSummary summary;
  EXPECT_EQ(why_nothing_is_tracked(summary, camera), "there was none");
  summary.not_tracked = {{0, 1, FrameState::not_initialised, "waiting for a first view"},
                         {2, 9, FrameState::not_initialised, "waiting for parallax"}};
  EXPECT_EQ(why_nothing_is_tracked(summary, camera), "waiting for parallax (8 of 10 frames)");
  camera.pinhole.fx = 1;
  EXPECT_NE(why_nothing_is_tracked(summary, camera).find("a focal length of 1 pixels"), std::string::npos);
}

TEST(RunText, TellsWhatBecameOfALiveCamera) {
  RunRecord run = made_record();
  run.dropped = 12;
  run.frames.push_back(skipped_frame(10, 0, FrameState::camera_gone, "gone"));
  run.failure = "another size";
  const RunSummary summary = summarise(run, made_snapshot(), nullptr, 0);
  const std::string text = summary_text(summary, "out");
  EXPECT_NE(text.find("6 of 10 frames tracked"), std::string::npos) << text;
  EXPECT_NE(text.find("12 frames dropped for newer ones; the camera went away 1 time\nended early: another size\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(summary_rows(summary).size(), 10u);
}

TEST(RunText, WarningsAreSaid) {
  RunRecord run = made_record();
  run.warnings = {{SensorDoubt::depth_against_motion, 1.25, 8}};
  const RunSummary summary = summarise(run, made_snapshot(), nullptr, 0);
  EXPECT_NE(summary_text(summary, "out").find("warning: depth contradicts the motion"), std::string::npos);
  EXPECT_EQ(summary_rows(summary).back().first, "warning, frame 8");
}

TEST(RunText, RowsOfTheReport) {
  const Snapshot snapshot = made_snapshot();
  const Trajectory truth = main_submap(snapshot).trajectory;
  EXPECT_EQ(summary_rows(summarise(made_record(), snapshot, nullptr, 0)).size(), 8u);
  const auto rows = summary_rows(summarise(made_record(), snapshot, &truth, 0));
  ASSERT_EQ(rows.size(), 11u);
  EXPECT_EQ(rows[1], std::pair(std::string("frames tracked"), std::string("6 of 10")));
  EXPECT_EQ(rows[8].first, "error (ATE RMSE, se3)");
}

}  // namespace
}  // namespace covis::app
