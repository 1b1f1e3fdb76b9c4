// SPDX-License-Identifier: Apache-2.0
#include "covis/io/files.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class Pairs : public RecordingTest {
 protected:
  // Frames as 7-Scenes has them; each is a metre farther along z, turned by a quarter about z.
  void seven_scenes(int frames) const {
    for (int i = 0; i < frames; ++i) {
      const std::string name = "frame-00000" + std::to_string(i);
      image(name + ".color.png", 10 + i);
      depth(name + ".depth.png", 1000 * (i + 1));
      write(name + ".pose.txt", "0 -1 0 0\n1\t0\t0\t0\n0 0 1 " + std::to_string(i) + "\n0 0 0 1\n");
    }
    camera_yaml();
  }
};

TEST_F(Pairs, AreReadAs7ScenesHasThem) {
  seven_scenes(3);
  depth("frame-000001.depth.png", 65535);
  const auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->sensor(), Sensor::rgbd);
  EXPECT_EQ((*opened)->size(), 3);
  EXPECT_NEAR((*opened)->frame_rate(), 30, 1e-5);
  EXPECT_THAT((*opened)->notes(), IsEmpty());
  const auto first = (*opened)->next(), second = (*opened)->next();
  EXPECT_EQ((*first)->image(0, 0), 10);
  EXPECT_FLOAT_EQ((*first)->depth(5, 5), 1);
  EXPECT_EQ((*second)->depth(5, 5), 0) << "65535 is none";
  const auto truth = load_truth(**opened);
  ASSERT_TRUE(truth) << truth.error().message;
  ASSERT_EQ(truth->size(), 3u);
  EXPECT_EQ(truth->at(1).stamp, (*second)->stamp);
  EXPECT_TRUE(truth->at(1).T_wc.t().isApprox(Eigen::Vector3d(0, 0, 1), 1e-12));
  EXPECT_TRUE((truth->at(1).T_wc.R() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
  const auto mono = open({.sensor = Sensor::monocular});
  ASSERT_TRUE(mono) << mono.error().message;
  EXPECT_EQ((*mono)->size(), 3) << "the depth images are no images";
  EXPECT_THAT(open_error({.sensor = Sensor::stereo}), HasSubstr("--sensor must be rgbd or mono"));
  fs::remove(folder / "camera.yaml");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera.yaml"), HasSubstr("--camera")));
  EXPECT_EQ((*open_sequence(folder.string(), {.sensor = Sensor::monocular, .uncalibrated = true}))->size(), 3);
}

TEST_F(Pairs, FramesWithoutDepthOrPoseAreLeftOut) {
  seven_scenes(5);
  fs::remove(folder / "frame-000001.depth.png");
  write("frame-000002.pose.txt",
        "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n");
  write("frame-000003.pose.txt", "-1.#INF -1.#IND 1.#QNAN nan nan nan nan nan nan nan nan nan nan nan nan nan\n");
  const auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 4);
  EXPECT_THAT((*opened)->notes(), ElementsAre(HasSubstr("1 of 5 images have no depth image of their name")));
  const auto truth = load_truth(**opened);
  ASSERT_TRUE(truth) << truth.error().message;
  EXPECT_EQ(truth->size(), 3u);
  EXPECT_NEAR(to_seconds(truth->back().stamp), 4 / 30.0, 1e-6) << "of its own frame";
  for (const auto& [text, problem] : {std::pair("1 0 0 0\n", "it has 4 numbers; a pose is a 4x4 matrix"),
                                      {"1 0 0 0 0 1 0 0 0 0 1 x 0 0 0 1", "'x' is not a number"},
                                      {"1 0 0 0 0 2 0 0 0 0 1 0 0 0 0 1", "it is no pose"},
                                      {"1 0 0 0 0 1 0 0 0 0 1 0 1 2 3 1", "it is no pose"}}) {
    write("frame-000004.pose.txt", text);
    const auto wrong = load_truth(**opened);
    ASSERT_FALSE(wrong) << text;
    EXPECT_THAT(wrong.error().message, AllOf(HasSubstr("frame-000004.pose.txt: "), HasSubstr(problem)));
  }
}

TEST_F(Pairs, AreReadWithOtherNames) {
  for (const char* name : {"00000", "00001"}) {
    image(std::string(name) + "-color.png", 7);
    depth(std::string(name) + "-depth.png", 2000);
  }
  camera_yaml("fps: 15\ndepth_scale: 10000\n");
  const auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 2);
  EXPECT_NEAR((*opened)->frame_rate(), 15, 1e-5);
  EXPECT_FLOAT_EQ((*(*opened)->next())->depth(0, 0), 0.2f);
  EXPECT_FALSE((*opened)->truth());
  fs::remove(folder / "00000-depth.png");
  image("other-color.png", 7);
  EXPECT_EQ((*open())->kind(), SequenceKind::images) << "a single depth image of three";
}

TEST_F(Pairs, AreReadAsReplicaIsRendered) {
  std::string rows;
  for (int i = 0; i < 3; ++i) {
    const std::string number = "00000" + std::to_string(i);
    image("results/frame" + number + ".jpg", 40);
    depth("results/depth" + number + ".png", 13107);
    rows += "1 0 0 " + std::to_string(i) + " 0 1 0 0 0 0 1 0 0 0 0 1\n";
  }
  write("traj.txt", rows);
  camera_yaml();
  fs::remove(folder / "results/frame000000.jpg");
  const auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 2);
  EXPECT_FLOAT_EQ((*(*opened)->next())->depth(0, 0), 2);
  const auto truth = load_truth(**opened);
  ASSERT_TRUE(truth) << truth.error().message;
  ASSERT_EQ(truth->size(), 2u);
  EXPECT_NEAR(truth->front().T_wc.t().x(), 1, 1e-12) << "of the row that its frame has the number of";
  write("traj.txt", "1 0 0 0\n");
  EXPECT_THAT(load_truth(**opened).error().message, HasSubstr("traj.txt:1: it has 4 numbers"));
}

}  // namespace
}  // namespace covis::io
