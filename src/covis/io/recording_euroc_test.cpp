// SPDX-License-Identifier: Apache-2.0
#include "covis/io/files.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST_F(Sequences, ReadsEurocAndRectifies) {
  euroc();
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  Sequence& s = **opened;
  EXPECT_EQ(s.kind(), SequenceKind::euroc);
  EXPECT_EQ(s.sensor(), Sensor::stereo);
  EXPECT_NEAR(s.camera().pinhole.baseline(), 0.1, 1e-9);
  EXPECT_EQ(s.camera().distortion, Distortion::none);
  const auto frame = s.next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->stamp, 1403715273262142976);
  EXPECT_EQ((*frame)->image(32, 24), 50);
  EXPECT_EQ((*frame)->right(32, 24), 51);
  // The truth is of the body at (1, 2, 3): the camera is 0.5 m along x from it, turned by a quarter about z.
  const auto truth = load_truth(s);
  ASSERT_TRUE(truth);
  EXPECT_TRUE(truth->front().T_wc.t().isApprox(Eigen::Vector3d(1.5, 2, 3), 1e-9));
  EXPECT_TRUE((truth->front().T_wc.R() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-9));
  auto mono = open({.sensor = Sensor::monocular});
  ASSERT_TRUE(mono);
  EXPECT_EQ((*mono)->camera().distortion, Distortion::brown_conrady);
  EXPECT_EQ((*mono)->camera().pinhole.bf, 0);
  euroc("equidistant");
  EXPECT_EQ((*open({.sensor = Sensor::monocular}))->camera().distortion, Distortion::kannala_brandt);
}

TEST_F(Sequences, PassesOverWhatACopyOfEurocLeavesOut) {
  euroc();
  fs::remove(folder / "mav0/cam0/data/1403715273262142976.png");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 1);
  EXPECT_THAT((*opened)->notes(), testing::ElementsAre(HasSubstr("1 of 2 images")));
  euroc();
  write("mav0/cam1/data.csv", "1403715273262142976,1403715273262142976.png\n");
  EXPECT_THAT((*open())->notes(), testing::ElementsAre(HasSubstr("no right image")));
  EXPECT_THAT((*open())->losses(), testing::ElementsAre(HasSubstr("1 of 2 images"))) << "a list that was cut short";
  euroc();
  for (const char* cam : {"cam0", "cam1"}) fs::remove(folder / "mav0" / cam / "data.csv");
  EXPECT_EQ((*open())->size(), 2);
}

TEST_F(Sequences, ReadsEurocImagesThatAreRectifiedAlready) {
  euroc();
  camera_yaml("baseline: 0.2\n");
  auto opened = open({.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.2, 1e-12);
  EXPECT_EQ((*(*opened)->next())->right(0, 0), 51) << "taken as it is, without the black border of a rectified image";
}

// Reading a part of what describes a camera makes another camera of it.
TEST_F(Sequences, ReadsEurocWithAGivenCameraWhateverItsOwnFileSays) {
  euroc();
  camera_yaml("baseline: 0.2\n");
  const auto x_of_truth = [&](Sequence& sequence) { return load_truth(sequence)->front().T_wc.t().x(); };
  auto opened = open({.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_THAT((*opened)->notes(), testing::IsEmpty());
  EXPECT_NEAR(x_of_truth(**opened), 1.5, 1e-9);
  const std::string sensor = *read_text(folder / "mav0/cam0/sensor.yaml");
  write("mav0/cam0/sensor.yaml", sensor + "camera_model: omni\n");
  opened = open({.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_THAT((*opened)->notes(), testing::IsEmpty());
  EXPECT_NEAR(x_of_truth(**opened), 1.5, 1e-9) << "where the camera is on the body can be read all the same";
  write("mav0/cam0/sensor.yaml", "T_BS: 5\n");
  opened = open({.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.2, 1e-12);
  EXPECT_NEAR(x_of_truth(**opened), 1, 1e-9) << "the body's";
  EXPECT_THAT((*opened)->notes(), testing::ElementsAre(AllOf(HasSubstr("cam0/sensor.yaml"), HasSubstr("'T_BS'"),
                                                             HasSubstr("on the body is not known"),
                                                             HasSubstr("state_groundtruth_estimate0"))));
  fs::remove(folder / "mav0/cam0/sensor.yaml");
  opened = open({.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_THAT((*opened)->notes(), testing::ElementsAre(AllOf(HasSubstr("cam0/sensor.yaml: it is not there"),
                                                             HasSubstr("on the body is not known"),
                                                             HasSubstr("state_groundtruth_estimate0"))));
  fs::remove_all(folder / "mav0/state_groundtruth_estimate0");
  opened = open({.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_THAT((*opened)->notes(), testing::IsEmpty()) << "nothing asks for the body";
}

TEST_F(BadInput, EurocCamerasOfMoreThanCovisKnowsAreRefused) {
  const auto with = [&](const std::string& from, const std::string& to) {
    euroc();
    std::string text = *read_text(folder / "mav0/cam0/sensor.yaml");
    write("mav0/cam0/sensor.yaml", text.replace(text.find(from), from.size(), to));
    const auto opened = open();
    return opened ? "" : opened.error().message;
  };
  const std::string intrinsics = "intrinsics: [50, 50, 32, 24]", coefficients = "[-0.1, 0.01, 0, 0]";
  EXPECT_THAT(with(intrinsics, "camera_model: omni\nintrinsics: [0.7, 50, 50, 32, 24]"),
              AllOf(HasSubstr("cam0/sensor.yaml:7: camera_model 'omni'"), HasSubstr("must be pinhole")));
  EXPECT_EQ(with(intrinsics, "camera_model: pinhole\n" + intrinsics), "");
  EXPECT_THAT(with(intrinsics, "intrinsics: [0.7, 50, 50, 32, 24]"),
              AllOf(HasSubstr("cam0/sensor.yaml:7: intrinsics has 5 numbers"), HasSubstr("4 of a pinhole camera")));
  EXPECT_THAT(with(coefficients, "[-0.1, 0.01, 0, 0, 0, 0.2, 0, 0]"),
              AllOf(HasSubstr("cam0/sensor.yaml:9: distortion_coefficients has 8 numbers"), HasSubstr("k1 k2 p1 p2")));
  EXPECT_EQ(with(coefficients, "[-0.1, 0.01, 0, 0, 0, 0, 0, 0]"), "");
  EXPECT_THAT(with("radial-tangential\ndistortion_coefficients: [-0.1, 0.01, 0, 0]",
                   "equidistant\ndistortion_coefficients: [-0.1, 0.01, 0, 0, 0]"),
              AllOf(HasSubstr("distortion_coefficients has 5 numbers"), HasSubstr("k1 k2 k3 k4")));
}

TEST_F(BadInput, Euroc) {
  euroc();
  fs::remove(folder / "mav0/cam1/data/1403715273312143104.png");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("cam1/data/1403715273312143104.png"), HasSubstr("missing")));
  fs::remove_all(folder / "mav0/cam0/data");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("cam0"), HasSubstr("none of the images")));
  euroc();
  write("mav0/cam0/data.csv", "2,b.png\n1,a.png\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("data.csv:2"), HasSubstr("must rise")));
  euroc("omnidirectional");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("sensor.yaml"), HasSubstr("omnidirectional"), HasSubstr("equidistant")));
  euroc();
  const std::string right = *read_text(folder / "mav0/cam1/sensor.yaml");
  write("mav0/cam1/sensor.yaml", *read_text(folder / "mav0/cam0/sensor.yaml"));
  EXPECT_THAT(open_error(), HasSubstr("to the right of the left one"));
  write("mav0/cam1/sensor.yaml", "T_BS: {data: [1, 2, x]}\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("cam1/sensor.yaml:1"), HasSubstr("'x'")));
  write("mav0/cam1/sensor.yaml", "T_BS: 5\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("cam1/sensor.yaml"), HasSubstr("'T_BS'")));
  for (const char* size : {"1e12, 48", "64, 48.5", "-64, 48", "nan, 48"}) {
    std::string text = right;
    write("mav0/cam1/sensor.yaml", text.replace(text.find("64, 48"), 6, size));
    EXPECT_THAT(open_error(), AllOf(HasSubstr("cam1/sensor.yaml"), HasSubstr("resolution"))) << size;
  }
  fs::remove_all(folder / "mav0/cam1");
  EXPECT_THAT(open_error({.sensor = Sensor::stereo}), AllOf(HasSubstr("cam1"), HasSubstr("--sensor mono")));
  fs::remove(folder / "mav0/cam0/sensor.yaml");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("sensor.yaml"), HasSubstr("--camera")));
}

}  // namespace
}  // namespace covis::io
