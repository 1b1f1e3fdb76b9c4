// SPDX-License-Identifier: Apache-2.0
#include "covis/io/trajectory.h"

#include "covis/io/files.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Trajectories : public RecordingTest {};

TEST_F(Trajectories, FullDiskIsAnErrorOfATrajectory) {
  fs::create_symlink("/dev/full", folder / "full");
  Trajectory one(1);
  EXPECT_THAT(write_trajectory(folder / "full", one, TrajectoryFormat::tum).error().message,
              HasSubstr("No space left"));
}

TEST_F(Trajectories, AreReadAsTartanAirAndIclNuimHaveThem) {
  write("pose_left.txt", "1 2 3 0 0 0 1\n4 5 6 0 0 0 1\n");
  write("times.txt", "0\n0.5\n");
  EXPECT_EQ(read_trajectory(folder / "pose_left.txt")->back().stamp, kTartanAirStep);
  EXPECT_EQ(read_trajectory(folder / "pose_left.txt", TrajectoryFormat::automatic, folder / "times.txt")->back().stamp,
            500'000'000);
  write("times.txt", "0\n");
  EXPECT_THAT(
      read_trajectory(folder / "pose_left.txt", TrajectoryFormat::automatic, folder / "times.txt").error().message,
      AllOf(HasSubstr("pose_left.txt: it has 2 rows"), HasSubstr("times.txt has 1 stamps")));
  write("pose_left.txt", "1 2 3 0 0 0 2\n");
  EXPECT_THAT(read_trajectory(folder / "pose_left.txt").error().message, HasSubstr("the rotation is not valid"));
  write("traj0.gt.freiburg", "30 1 2 3 0.6 0 0 0.8\n");
  const auto numbered = read_trajectory(folder / "traj0.gt.freiburg");
  ASSERT_TRUE(numbered) << numbered.error().message;
  EXPECT_EQ(numbered->front().stamp, 1'000'000'000);
  EXPECT_TRUE(numbered->front().T_wc.t().isApprox(Eigen::Vector3d(1, -2, 3))) << "y points down here, and up there";
  EXPECT_TRUE(numbered->front().T_wc.q().isApprox(Eigen::Quaterniond(0.8, -0.6, 0, 0)));
  // The point 2 m above and 3 m before the camera is the same one in either pair of frames.
  write("traj0.gt.freiburg", "30 1 2 3 0.36 0.48 0.48 0.64\n");
  const Eigen::Quaterniond published(0.64, 0.36, 0.48, 0.48);
  const Eigen::Vector3d in_world = published * Eigen::Vector3d(1, 2, 3) + Eigen::Vector3d(1, 2, 3);
  EXPECT_TRUE((read_trajectory(folder / "traj0.gt.freiburg")->front().T_wc * Eigen::Vector3d(1, -2, 3))
                  .isApprox(Eigen::Vector3d(in_world.x(), -in_world.y(), in_world.z())));
}

// Rows of KITTI's format do not say which frames they are of: with stamps of more frames, each would get that of
// another.
TEST_F(Trajectories, MoreStampsThanRowsAreRefused) {
  write("part.txt", "1 0 0 5 0 1 0 0 0 0 1 0\n1 0 0 6 0 1 0 0 0 0 1 0\n");
  write("times.txt", "0\n1\n2\n");
  EXPECT_THAT(
      read_trajectory(folder / "part.txt", TrajectoryFormat::automatic, folder / "times.txt").error().message,
      AllOf(HasSubstr("part.txt: it has 2 rows"), HasSubstr("times.txt has 3 stamps; a file with one stamp for each")));
}

TEST_F(Trajectories, StampsAreWrittenBesideRowsThatHaveNone) {
  const Trajectory poses{{1'500'000'001, SE3()}, {7'000'000'000, SE3()}};
  ASSERT_TRUE(write_trajectories(folder / "t.txt", {poses, {poses.back()}}, TrajectoryFormat::kitti));
  const auto read = read_trajectory(folder / "t.txt", TrajectoryFormat::automatic, times_file(folder / "t.txt"));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->front().stamp, 1'500'000'001);
  EXPECT_EQ(read->back().stamp, 7'000'000'000);
  EXPECT_EQ(*read_text(folder / "t_map1_times.txt"), "# seconds of each row of t_map1.txt\n7.000000000\n");
  ASSERT_TRUE(write_trajectories(folder / "t.txt", {poses}, TrajectoryFormat::kitti));
  EXPECT_FALSE(fs::exists(folder / "t_map1_times.txt"));
  ASSERT_TRUE(write_trajectories(folder / "t.txt", {poses}, TrajectoryFormat::tum));
  EXPECT_FALSE(fs::exists(folder / "t_times.txt")) << "it would be taken for that of these rows";
  write("t_times.txt", "notes");
  ASSERT_TRUE(write_trajectories(folder / "t.txt", {poses}, TrajectoryFormat::tum));
  EXPECT_EQ(*read_text(folder / "t_times.txt"), "notes");
  EXPECT_THAT(write_trajectories(folder / "t.txt", {poses}, TrajectoryFormat::kitti).error().message,
              HasSubstr("t_times.txt: it is there and is not a file of stamps that Covis wrote"));
}

// EuRoC's quaternions begin with w.
TEST_F(Trajectories, CommasAloneMakeNoEurocFile) {
  write("tum.csv", "1305031102.1753,1,2,3,0.6,0,0,0.8\n");
  write("euroc.csv", "#timestamp\n1403636579763555584,1,2,3,0.8,0.6,0,0\n");
  EXPECT_EQ(*trajectory_format(folder / "tum.csv", TrajectoryFormat::automatic), TrajectoryFormat::tum);
  EXPECT_EQ(*trajectory_format(folder / "euroc.csv", TrajectoryFormat::automatic), TrajectoryFormat::euroc);
  EXPECT_TRUE(read_trajectory(folder / "tum.csv")
                  ->front()
                  .T_wc.R()
                  .isApprox(read_trajectory(folder / "euroc.csv")->front().T_wc.R()));
}

TEST_F(Trajectories, TheFirstRowTellsTheFormatOfAll) {
  write("t.txt", "0 1 2 3 0 0 0 1\n1 0 0 1 0 1 0 2 0 0 1 3\n");
  EXPECT_THAT(read_trajectory(folder / "t.txt").error().message, HasSubstr("t.txt:2: it has 12 columns"));
}

TEST_F(Trajectories, APositionBeyondReasonIsRefused) {
  write("t.txt", "0 1e12 0 0 0 0 0 1\n1 0 1e308 0 0 0 0 1\n");
  EXPECT_THAT(read_trajectory(folder / "t.txt").error().message, HasSubstr("t.txt:2: the position is farther than"));
}

TEST_F(Trajectories, TrajectoriesRoundTripExactly) {
  Trajectory trajectory;
  for (int i = 0; i < 5; ++i) {
    Vector6d xi;
    xi << 1 * i, 2, 3, 0.1 * i, 0.2, 0.3;
    trajectory.push_back({1403715273262142976 + i * 1001, SE3::exp(xi)});
  }
  for (const TrajectoryFormat format : {TrajectoryFormat::tum, TrajectoryFormat::euroc, TrajectoryFormat::kitti}) {
    ASSERT_TRUE(write_trajectory(folder / "t.txt", trajectory, format));
    const auto read = read_trajectory(folder / "t.txt");
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->size(), 5u);
    for (size_t i = 0; i < 5; ++i) {
      if (format != TrajectoryFormat::kitti) {
        EXPECT_EQ((*read)[i].stamp, trajectory[i].stamp);
      }
      EXPECT_LT(((*read)[i].T_wc.t() - trajectory[i].T_wc.t()).norm(), 1e-7);
      EXPECT_LT(((*read)[i].T_wc.R() - trajectory[i].T_wc.R()).norm(), 1e-7);
    }
  }
  // Whole numbers of EuRoC rows are nanoseconds, however few; stamps with a comma may be seconds all the same.
  ASSERT_TRUE(write_trajectory(folder / "t.csv", {{33'333'333, SE3()}}, TrajectoryFormat::euroc));
  EXPECT_EQ(read_trajectory(folder / "t.csv")->front().stamp, 33'333'333);
  write("t.csv", "0.5,0,0,0,1,0,0,0\n");
  EXPECT_EQ(read_trajectory(folder / "t.csv")->front().stamp, 500'000'000);
  write("bad.txt", "# t\n1 2 3\n");
  EXPECT_THAT(read_trajectory(folder / "bad.txt").error().message, HasSubstr("bad.txt:2"));
  write("bad.txt", "1 0 0 0 0 0 0 nan\n");
  EXPECT_FALSE(read_trajectory(folder / "bad.txt"));
  write("bad.txt", "1 0 0 0 0 0 0 7\n");
  EXPECT_THAT(read_trajectory(folder / "bad.txt").error().message, HasSubstr("rotation"));
}

TEST_F(Trajectories, GreatNumbersAreWrittenWhole) {
  const double great = 1e308;
  const SE3 far(Eigen::Matrix3d::Identity(), Eigen::Vector3d(great, -great, 1));
  for (const TrajectoryFormat format : {TrajectoryFormat::tum, TrajectoryFormat::euroc, TrajectoryFormat::kitti}) {
    ASSERT_TRUE(write_trajectory(folder / "t.txt", {{0, far}}, format));
    const std::string text = *read_text(folder / "t.txt");
    std::vector<std::string_view> row;  // the last one: EuRoC has a headline
    for_each_line(text, [&](std::string_view line, int) {
      row = split(line);
      return true;
    });
    const bool kitti = format == TrajectoryFormat::kitti;
    for (size_t k = 0; k < 3; ++k) {
      const double value = parse_double(row.at(kitti ? 4 * k + 3 : k + 1)).value_or(0);
      EXPECT_NEAR(value / far.t()(static_cast<Eigen::Index>(k)), 1, kitti ? 1e-9 : 0) << "KITTI has nine digits";
    }
  }
}

TEST_F(Trajectories, EachMapHasAFileAndThoseOfAnEarlierRunGo) {
  const Trajectory one{{1, SE3()}}, two{{1, SE3()}, {2, SE3()}};
  ASSERT_TRUE(write_trajectories(folder / "t.txt", {two, one, one}, TrajectoryFormat::tum));
  EXPECT_EQ(read_trajectory(folder / "t.txt")->size(), 2u);
  EXPECT_EQ(read_trajectory(folder / "t_map2.txt")->size(), 1u);
  write("t_map7.txt", "not ours: a gap lies before it");
  ASSERT_TRUE(write_trajectories(folder / "t.txt", {one}, TrajectoryFormat::tum));
  EXPECT_EQ(read_trajectory(folder / "t.txt")->size(), 1u);
  EXPECT_FALSE(fs::exists(folder / "t_map1.txt"));
  EXPECT_FALSE(fs::exists(folder / "t_map2.txt"));
  EXPECT_TRUE(fs::exists(folder / "t_map7.txt"));
}

}  // namespace
}  // namespace covis::io
