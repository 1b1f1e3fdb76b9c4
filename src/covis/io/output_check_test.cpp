// SPDX-License-Identifier: Apache-2.0
#include "covis/io/output_check.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <opencv2/core.hpp>

#include "covis/core/test_folder.h"
#include "covis/io/camera_file.h"
#include "covis/io/codecs.h"
#include "covis/io/outputs.h"
#include "covis/io/plugin.h"
#include "covis/io/trajectory.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class OutputCheck : public testing::Test {
 protected:
  // The kinds, among those asked after, that may replace a file of these bytes.
  std::vector<OutputKind> replaced_by(const std::string& bytes) const {
    write_file(file, bytes);
    std::vector<OutputKind> kinds;
    for (int k = 0; k <= static_cast<int>(OutputKind::json); ++k) {
      if (*may_replace(file, static_cast<OutputKind>(k))) kinds.push_back(static_cast<OutputKind>(k));
    }
    return kinds;
  }
  using Kinds = std::vector<OutputKind>;
  const TemporaryFolder folder;
  const fs::path file = folder / "file";
};

TEST_F(OutputCheck, EachKindReplacesItsOwnAlone) {
  for (const auto format : {TrajectoryFormat::tum, TrajectoryFormat::kitti, TrajectoryFormat::euroc}) {
    ASSERT_TRUE(write_trajectory(folder / "poses", {{1, {}}, {2, {}}}, format));
    EXPECT_EQ(replaced_by(read_file(folder / "poses")), Kinds{OutputKind::trajectory});
  }
  ASSERT_TRUE(write_ply(folder / "ply", {}));
  EXPECT_EQ(replaced_by(read_file(folder / "ply")), Kinds{OutputKind::point_cloud});
  EXPECT_EQ(replaced_by("ply\nformat ascii 1.0\n"), Kinds{OutputKind::point_cloud});
  EXPECT_EQ(replaced_by("# covis calibrate: 9 views\n" + camera_text({})), Kinds{OutputKind::camera});
  EXPECT_EQ(replaced_by(std::string(kCameraEstimate) + ", by 9\n" + camera_text({})),
            (Kinds{OutputKind::camera, OutputKind::camera_estimate}));
  EXPECT_EQ(replaced_by("COVISVOC"), Kinds{OutputKind::vocabulary});
  EXPECT_EQ(replaced_by("10 5 0 0\n0 1 2"), Kinds{OutputKind::vocabulary});
  EXPECT_EQ(replaced_by("").size(), 15u) << "nothing is lost";
}

TEST_F(OutputCheck, FilesOfOthersAreNotReplaced) {
  EXPECT_EQ(replaced_by("# timestamp tx ty tz qx qy qz qw\n1.5 0 0 0 0 0 0 1\n"), Kinds{});
  EXPECT_EQ(replaced_by("1305031102.1753 1.3563 0.6305 1.6380 0.6132 0.5962 -0.3311 -0.3986\n"), Kinds{});
  EXPECT_EQ(replaced_by("# my notes"), Kinds{});
  EXPECT_EQ(replaced_by(camera_text({})), Kinds{}) << "a camera file that its owner wrote";
  EXPECT_EQ(replaced_by("# Camera list with one line of data per camera:\n"), Kinds{});
  EXPECT_EQ(replaced_by("COVISMAP"), Kinds{});
  EXPECT_EQ(replaced_by("525 525 320 240\n"), Kinds{}) << "four numbers are a camera";
}

TEST_F(OutputCheck, AFileThatCantBeReadIsNamed) {
  if (geteuid() == 0) GTEST_SKIP() << "root may read anything";
  write_file(file, "ply\n");
  fs::permissions(file, fs::perms::none);
  EXPECT_THAT(check_output(file, OutputKind::point_cloud).error().message,
              AllOf(HasSubstr(file.string()), HasSubstr("ermission")));
}

TEST_F(OutputCheck, APictureKnowsItsOwn) {
  const cv::Mat image(20, 30, CV_8UC1, cv::Scalar(7));
  const std::string png = *encode_image(".png", image), marked = marked_picture(png);
  EXPECT_EQ(replaced_by(png), Kinds{OutputKind::png});
  EXPECT_EQ(replaced_by(marked), (Kinds{OutputKind::picture, OutputKind::png}));
  cv::Mat bytes(1, static_cast<int>(marked.size()), CV_8UC1, const_cast<char*>(marked.data())), read;
  (*plugin<CodecPlugin>())->decode(bytes, cv::IMREAD_UNCHANGED, read);
  EXPECT_EQ(cv::norm(read, image, cv::NORM_INF), 0) << "it is the picture that it was";
}

TEST_F(OutputCheck, WhatIsGivenStaysUnderAnyName) {
  write_file(file, std::string(kCameraFile) + "calibrate\n" + camera_text({}));
  fs::create_symlink(file, folder / "link");
  fs::create_hard_link(file, folder / "other");
  for (const char* name : {"file", "link", "other"}) {
    const auto checked = check_output(folder / name, OutputKind::camera, {"", file});
    ASSERT_FALSE(checked) << name;
    EXPECT_THAT(checked.error().message, AllOf(HasSubstr(name), HasSubstr("left as they are")));
  }
  EXPECT_TRUE(check_output(file, OutputKind::camera, {folder / "new"}));
  EXPECT_FALSE(check_output(folder / "./new", OutputKind::camera, {folder / "new"})) << "neither is there yet";
  fs::create_symlink("loop", folder / "loop");
  EXPECT_TRUE(check_other_file(folder / "loop/a", {folder / "loop/b"})) << "two names that lead nowhere";
  EXPECT_FALSE(check_other_file(folder / "loop/a", {folder / "loop/./a"}));
  EXPECT_THAT(check_output(file, OutputKind::picture).error().message,
              HasSubstr("file: it is there and is not a picture that Covis made, so that it is not replaced; remove"));
}

TEST_F(OutputCheck, TrajectoriesOfMapsThatAreNoMoreGoButNoFileOfOthers) {
  const Trajectory poses{{1, {}}};
  ASSERT_TRUE(write_trajectories(folder / "t.txt", {poses, poses}, TrajectoryFormat::tum));
  write_file(folder / "t_map2.txt", "notes");
  ASSERT_TRUE(write_trajectories(folder / "t.txt", {poses}, TrajectoryFormat::tum));
  EXPECT_FALSE(fs::exists(folder / "t_map1.txt"));
  ASSERT_TRUE(write_trajectories(folder / "t.txt", {poses, poses}, TrajectoryFormat::tum));
  EXPECT_EQ(read_file(folder / "t_map2.txt"), "notes");
  EXPECT_THAT(write_trajectories(folder / "t.txt", {poses, poses, poses}, TrajectoryFormat::tum).error().message,
              HasSubstr("t_map2.txt: it is there and is not a trajectory"));
  EXPECT_EQ(read_file(folder / "t_map2.txt"), "notes");
  EXPECT_THAT(check_trajectories(folder / "t.txt", {}).error().message,
              HasSubstr("t_map2.txt: it is there and is not"));
  fs::remove(folder / "t_map2.txt");
  write_file(folder / "t_map1_times.txt", "notes");
  EXPECT_TRUE(check_trajectories(folder / "t.txt", {}));
  EXPECT_THAT(check_trajectories(folder / "t.txt", {}, TrajectoryFormat::kitti).error().message,
              HasSubstr("t_map1_times.txt: it is there and is not a file of stamps"));
  EXPECT_THAT(check_trajectories(folder / "t.txt", {folder / "t_map1.txt"}).error().message,
              HasSubstr("t_map1.txt: it is also "));
}

}  // namespace
}  // namespace covis::io
