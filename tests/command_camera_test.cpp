// SPDX-License-Identifier: Apache-2.0
// covis run on recordings without a calibration: the camera is found from the images, or it is said that they do not
// tell it.
#include <cmath>
#include <fstream>

#include "command_results.h"
#include "command_video.h"
#include "covis/io/camera_file.h"

namespace covis {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

using CommandCamera = CommandTest;

TEST_F(CommandCamera, IsFoundFromAVideoAndWrittenLong) {
  const fs::path recording = render("mono", 150), video = folder / "walk.avi", out = folder / "out";
  const auto truth = io::load_camera(recording / "camera.yaml");
  ASSERT_TRUE(truth);
  ASSERT_NO_FATAL_FAILURE(write_video(recording, video, 30));
  const Outcome run = covis({"run", video, "--out", out});
  ASSERT_EQ(run.code, 0) << run.error;
  EXPECT_THAT(run.out, AllOf(HasSubstr("the camera is an estimate from the recording"), HasSubstr("camera.yaml")));
  expect_results(out);
  const json summary = parsed(out / "summary.json");
  const double off = summary["camera_given"]["fx"].get<double>() / truth->camera.pinhole.fx - 1;
  const double sigma = summary["camera_estimate"]["focal_sigma"].get<double>();
  EXPECT_LT(std::abs(off), 0.02);
  EXPECT_LT(std::abs(off), 4 * sigma);
  EXPECT_LT(sigma, 0.04);
  const Outcome eval =
      covis({"eval", out / "trajectory.txt", recording / "groundtruth.txt", "--align", "sim3", "--json"});
  ASSERT_EQ(eval.code, 0) << eval.error;
  const json errors = json::parse(eval.out, nullptr, false);
  EXPECT_LT(errors["ate_m"]["rmse"].get<double>(), 0.02);
  EXPECT_GT(errors["coverage"].get<double>(), 0.9);

  const auto found = io::load_camera(out / "camera.yaml");
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->camera.pinhole.fx, summary["camera_given"]["fx"].get<double>());
  EXPECT_THAT(text_of(out / "camera.yaml"), HasSubstr("# An estimate from the recording itself"));
  const Outcome again = covis({"run", video, "--camera", out / "camera.yaml", "--quiet", "--out", folder / "again"});
  ASSERT_EQ(again.code, 0) << again.error;
  EXPECT_EQ(text_of(folder / "again/trajectory.txt"), text_of(out / "trajectory.txt"));
}

TEST_F(CommandCamera, OfItsOwnerIsNotReplacedByAnEstimate) {
  const fs::path recording = render("mono", 3), out = folder / "out";
  fs::create_directories(out);
  fs::rename(recording / "camera.yaml", out / "camera.yaml");
  const std::string before = text_of(out / "camera.yaml");
  const Outcome run = covis({"run", recording, "--quiet", "--out", out});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.error, AllOf(HasSubstr("camera.yaml: it is there and is not a camera that covis run found"),
                               HasSubstr("give it with --camera")));
  EXPECT_EQ(text_of(out / "camera.yaml"), before);
}

TEST_F(CommandCamera, ThatCanHardlyBeRightIsNamedByRunAsByCheck) {
  const fs::path recording = render("rgbd", 3), camera = folder / "wide.yaml";
  auto file = io::load_camera(recording / "camera.yaml");
  ASSERT_TRUE(file);
  file->camera.pinhole.fx = file->camera.pinhole.fy = 5;
  std::ofstream(camera) << io::camera_text(*file);
  const auto doubt = HasSubstr("a focal length of 5 pixels means");
  EXPECT_THAT(covis({"run", recording, "--camera", camera, "--quiet", "--out", folder / "out"}).error, doubt);
  const Outcome check = covis({"check", recording, "--camera", camera, "--out", folder / "check.png"});
  EXPECT_EQ(check.code, 1);
  EXPECT_THAT(check.out, doubt);
}

TEST_F(CommandCamera, ThatTheImagesDoNotTellIsAskedForLong) {
  const fs::path recording = render("mono", 1), still = folder / "still";
  fs::create_directories(still);
  for (int i = 0; i < 20; ++i)
    fs::copy_file(fs::directory_iterator(recording / "images")->path(), still / (std::to_string(i) + ".png"));
  const Outcome run = covis({"run", still, "--out", folder / "out"});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.error, AllOf(HasSubstr(still.string() + ": no camera is given"), HasSubstr("must move sideways"),
                               HasSubstr("--camera FILE"), HasSubstr("covis calibrate")));
  EXPECT_THAT(run.out, Not(HasSubstr("written to")));
  EXPECT_FALSE(fs::exists(folder / "out/camera.yaml"));
}

// A live camera's images can't be played again.
TEST_F(CommandCamera, OfALiveCameraIsAskedFor) {
  const Outcome run = covis({"run", "987", "--out", folder / "out"});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.error, AllOf(HasSubstr("987: a live camera needs a camera file, --camera FILE"),
                               HasSubstr("can't be played again"), HasSubstr("covis calibrate")));
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(CommandCamera, IsNotFoundForAMapThatHasOne) {
  const fs::path recording = render("mono", 3);
  fs::remove(recording / "camera.yaml");
  const Outcome run = covis({"run", recording, "--map", folder / "some.m", "--out", folder / "out"});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.error, AllOf(HasSubstr("no camera calibration found"), HasSubstr("--camera FILE")));
}

}  // namespace
}  // namespace covis
