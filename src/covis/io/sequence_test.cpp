// SPDX-License-Identifier: Apache-2.0
// Opening recordings: what is recognised, and what is said of bad ones.
#include "covis/io/sequence.h"

#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST_F(Sequences, MonocularCamerasHaveNoBaseLine) {
  tum();
  camera_yaml("baseline: 0.1\n");
  EXPECT_NEAR((*open())->camera().pinhole.bf, 5, 1e-12);
  EXPECT_EQ((*open({.sensor = Sensor::monocular}))->camera().pinhole.bf, 0);
  EXPECT_EQ((*open({.kind = SequenceKind::images}))->sensor(), Sensor::monocular);
}

TEST_F(BadInput, MissingFolder) {
  EXPECT_THAT(open_sequence((folder / "none").string(), {}).error().message,
              AllOf(HasSubstr("none"), HasSubstr("does not exist")));
}

TEST_F(BadInput, NoImages) {
  EXPECT_THAT(open_error(),
              AllOf(HasSubstr(folder.string()), HasSubstr("rgb.txt"), HasSubstr("image_0"), HasSubstr("mav0")));
  fs::create_directories(folder / "image_0");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("image_0"), HasSubstr("no image")));
}

TEST_F(BadInput, AbsentCalibration) {
  tum();
  fs::remove(folder / "camera.yaml");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("--camera"), HasSubstr("fx:")));
}

TEST_F(BadInput, UnreadableCalibration) {
  tum();
  write("camera.yaml", "width: [64\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera.yaml:"), HasSubstr("not YAML")));
  EXPECT_THAT(open_error({.camera_file = folder / "gone.yaml"}),
              AllOf(HasSubstr("gone.yaml"), HasSubstr("can't be opened")));
  kitti();
  write("calib.txt", "P0: 1 2 3\n");
  EXPECT_THAT(open_error({.kind = SequenceKind::kitti}), AllOf(HasSubstr("calib.txt:1"), HasSubstr("12")));
}

TEST_F(BadInput, UnknownKeyNamesTheNearest) {
  tum();
  camera_yaml("baselnie: 0.1\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera.yaml:7"), HasSubstr("'baselnie'"), HasSubstr("'baseline'")));
}

TEST_F(BadInput, ValueOutOfRangeAndNan) {
  tum();
  camera_yaml("depth_scale: -1\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("depth_scale"), HasSubstr("'-1'"), HasSubstr("from 0.001")));
  write("camera.yaml", "width: 64\nheight: 48\nfx: nan\nfy: 50\ncx: 32\ncy: 24\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera.yaml:3"), HasSubstr("fx"), HasSubstr("'nan'")));
  write("camera.yaml", "width: 64\nheight: 48\nfx: 50\nfy: 50\ncx: 32\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("'cy'"), HasSubstr("missing")));
  kitti();
  write("calib.txt", "P0: nan 0 32 0 0 50 24 0 0 0 1 0\n");
  EXPECT_THAT(open_error({.kind = SequenceKind::kitti}), AllOf(HasSubstr("calib.txt:1"), HasSubstr("'nan'")));
}

TEST_F(BadInput, StampsOutOfOrder) {
  tum();
  write("associations.txt", "2 rgb/0.png 2 depth/0.png\n1 rgb/1.png 1 depth/1.png\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("1.png"), HasSubstr("must rise")));
  kitti();
  write("times.txt", "0\n0.2\n0.1\n");
  EXPECT_THAT(open_error({.kind = SequenceKind::kitti}), AllOf(HasSubstr("000002.png"), HasSubstr("must rise")));
}

TEST_F(BadInput, SensorTheRecordingCannotGive) {
  kitti();
  EXPECT_THAT(open_error({.sensor = Sensor::rgbd}), HasSubstr("no depth images"));
}

TEST_F(BadInput, FolderThatIsNoRecordingSaysWhatItHolds) {
  EXPECT_THAT(open_error(), HasSubstr("It is empty"));
  write("notes.txt", "x");
  image("06/image_0/000000.png", 1);
  EXPECT_THAT(open_error(), AllOf(HasSubstr("06/, notes.txt"), HasSubstr("06 looks like a recording")));
}

TEST_F(BadInput, CalibrationOfAnotherCamera) {
  tum();
  write("camera.yaml", "width: 640\nheight: 480\nfx: 500\nfy: 500\ncx: 320\ncy: 240\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera.yaml"), HasSubstr("64x48"), HasSubstr("640x480")));
  write("camera.yaml", "width: 64\nheight: 48\nfx: 50\nfy: 50\ncx: 320\ncy: 24\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera.yaml:5"), HasSubstr("cx"), HasSubstr("'320'")));
  kitti();
  write("calib.txt", "P0: 50 0 320 0 0 50 24 0 0 0 1 0\nP1: 50 0 320 -25 0 50 24 0 0 0 1 0\n");
  EXPECT_THAT(open_error({.kind = SequenceKind::kitti}), AllOf(HasSubstr("calib.txt"), HasSubstr("principal point")));
}

TEST_F(BadInput, StampsMissingOrWrong) {
  kitti();
  write("times.txt", "0\n0.1\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("times.txt"), HasSubstr("2 stamps for 3 images")));
  write("times.txt", "0\nsoon\n0.2\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("times.txt:2"), HasSubstr("'soon'")));
  tum();
  write("rgb.txt", "1 rgb/0.png rgb/1.png\n");
  EXPECT_THAT(open_error({.kind = SequenceKind::tum}), HasSubstr("rgb.txt:1"));
  write("rgb.txt", "1 rgb/0.png\n");
  EXPECT_THAT(open_error({.kind = SequenceKind::tum}), HasSubstr("within 20 ms"));
}

TEST_F(BadInput, OptionsOutOfRange) {
  tum();
  EXPECT_THAT(open_error({.stride = 0}), HasSubstr("stride: 0"));
  EXPECT_THAT(open_error({.first = -1}), HasSubstr("first: -1"));
  EXPECT_THAT(open_error({.decode_ahead = 0}), HasSubstr("decode_ahead: 0"));
  EXPECT_THAT(open_error({.first = 3}), AllOf(HasSubstr("3 frames"), HasSubstr("from frame 3 on")));
}

TEST_F(BadInput, NamesThatCantBeOpened) {
  EXPECT_THAT(open_sequence(std::string(5000, 'x'), {}).error().message, HasSubstr("too long"));
  EXPECT_THAT(open_sequence("", {}).error().message, HasSubstr("does not exist"));
}

}  // namespace
}  // namespace covis::io
