// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_outputs.h"

#include <gmock/gmock.h>

#include "apps/run/test_run.h"
#include "covis/core/test_folder.h"

namespace covis::app {
namespace {

namespace fs = std::filesystem;

class RunOutputs : public testing::Test {
 protected:
  Result<void> write(OutputOptions options = {}) const {
    options.directory = folder.path();
    const RunSummary summary = summarise(made_record(), made_snapshot(), nullptr, 0);
    return write_outputs(made_record(), made_snapshot(), summary, options);
  }
  const TemporaryFolder folder;
};

TEST_F(RunOutputs, LeavesAllFiles) {
  const auto written = write();
  ASSERT_TRUE(written) << written.error().message;
  for (const char* file : {"trajectory.txt", "trajectory_map1.txt", "trajectory_online.txt", "keyframes.txt", "map.ply",
                           "stats.jsonl", "summary.json", "report.html", "trajectory.png"}) {
    EXPECT_GT(fs::file_size(folder / file), 0u) << file;
  }
  EXPECT_THAT(read_file(folder / "report.html"), testing::HasSubstr("reason 5"));
}

TEST_F(RunOutputs, StampsAreBesideTrajectoriesOfKitti) {
  ASSERT_TRUE(write({.directory = {}, .format = io::TrajectoryFormat::kitti, .title = {}}));
  for (const char* name : {"trajectory", "trajectory_map1", "trajectory_online", "keyframes"}) {
    const fs::path file = folder / (std::string(name) + ".txt"), times = io::times_file(file);
    EXPECT_TRUE(io::read_trajectory(file, io::TrajectoryFormat::kitti, times)) << name;
  }
  write_file(folder / "keyframes_times.txt", "notes");
  EXPECT_THAT(open_output_folder(folder.path(), {}).error().message, testing::HasSubstr("keyframes_times.txt: it is"));
}

// A run by one camera that was localised in a map in metres called them units of the map.
TEST_F(RunOutputs, PointsAreInTheUnitOfTheMap) {
  ASSERT_TRUE(write());
  EXPECT_THAT(read_file(folder / "map.ply"), testing::HasSubstr("metres"));
  OutputOptions options;
  options.unit = io::CloudUnit::of_map;
  ASSERT_TRUE(write(options));
  EXPECT_THAT(read_file(folder / "map.ply"), testing::HasSubstr("units of the map"));
}

TEST_F(RunOutputs, AFailureWithoutATrackedFrameIsWrittenWhereNoOlderResultsAre) {
  RunRecord failed = made_record();
  failed.failure = "camera 0: it is gone";
  const Snapshot nothing;
  EXPECT_FALSE(why_nothing_is_written(failed, nothing, folder.path()));
  OutputOptions options;
  options.directory = folder.path();
  ASSERT_TRUE(write_outputs(failed, nothing, summarise(failed, nothing, nullptr, 0), options));
  EXPECT_THAT(read_file(folder / "summary.json"), testing::HasSubstr("\"failure\": \"camera 0: it is gone\""));
  EXPECT_THAT(read_file(folder / "stats.jsonl"), testing::HasSubstr("reason 5"));
  EXPECT_THAT(why_nothing_is_written(failed, nothing, folder.path()).value_or(""),
              testing::HasSubstr("camera 0: it is gone; no frame was tracked, so that the older results in "));
  EXPECT_FALSE(why_nothing_is_written(failed, made_snapshot(), folder.path())) << "frames were tracked";
}

// Ctrl-C before the first pose replaced forty tracked frames by none.
TEST_F(RunOutputs, AnInterruptionBeforeTheFirstPoseLeavesOlderResults) {
  RunRecord stopped = made_record();
  stopped.interrupted = true;
  const Snapshot nothing;
  EXPECT_FALSE(why_nothing_is_written(stopped, nothing, folder.path())) << "there are none yet";
  ASSERT_TRUE(write());
  EXPECT_THAT(why_nothing_is_written(stopped, nothing, folder.path()).value_or(""),
              testing::HasSubstr("interrupted; no frame was tracked, so that the older results in "));
  EXPECT_FALSE(why_nothing_is_written(stopped, made_snapshot(), folder.path())) << "frames were tracked";
}

TEST_F(RunOutputs, ATrajectoryOfOthersIsRefusedBeforeTheRun) {
  write_file(folder / "trajectory_map12.txt", "notes");
  EXPECT_THAT(open_output_folder(folder.path(), {}).error().message,
              testing::HasSubstr("trajectory_map12.txt: it is there and is not a trajectory"));
  fs::rename(folder / "trajectory_map12.txt", folder / "trajectory_mapped.txt");
  EXPECT_TRUE(open_output_folder(folder.path(), {})) << "no run writes such a name";
}

TEST_F(RunOutputs, TheOthersAreWrittenWhenOneFails) {
  fs::create_directories(folder / "keyframes.txt" / "in the way");
  const auto written = write();
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, testing::HasSubstr("keyframes.txt"));
  EXPECT_TRUE(fs::exists(folder / "summary.json"));
  EXPECT_TRUE(fs::exists(folder / "map.ply"));
}

}  // namespace
}  // namespace covis::app
