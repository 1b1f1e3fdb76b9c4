// SPDX-License-Identifier: Apache-2.0
// Error messages for bad recordings.
#include "covis/io/files.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class BadInput : public RecordingTest {};

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

TEST_F(BadInput, OneTruncatedImage) {
  tum();
  const std::string whole = *read_text(folder / "rgb/1.png");
  write("rgb/1.png", whole.substr(0, whole.size() / 2));
  auto opened = open();
  ASSERT_TRUE(opened);
  EXPECT_TRUE((*opened)->next());
  const auto bad = (*opened)->next();
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad.error().message, AllOf(HasSubstr("1.png"), HasSubstr("cut short")));
  const auto after = (*opened)->next();
  ASSERT_TRUE(after && *after);
  EXPECT_EQ((*after)->index, 2);
}

TEST_F(BadInput, NotAnImage) {
  tum();
  write("rgb/0.png", "hello");
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr("0.png"), HasSubstr("not an image")));
  write("rgb/0.png", "");
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr("0.png"), HasSubstr("empty")));
}

TEST_F(BadInput, ImageOfAnotherSize) {
  tum();
  image("rgb/0.png", 1, 32, 24);
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr("0.png"), HasSubstr("32x24"), HasSubstr("64x48")));
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

TEST_F(BadInput, DepthFolderEmpty) {
  tum();
  fs::remove_all(folder / "depth");
  fs::create_directories(folder / "depth");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("depth/0.png"), HasSubstr("missing")));
  write("depth.txt", "# nothing\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("depth.txt"), HasSubstr("no file")));
}

TEST_F(BadInput, StereoPairWithoutItsRightImage) {
  kitti();
  fs::remove(folder / "image_1/000001.png");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("image_1/000001.png"), HasSubstr("right image"), HasSubstr("missing")));
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

TEST_F(BadInput, StereoPairThatIsNotRectifiedOrHasNoBaseLine) {
  kitti();
  const auto error = [&](const std::string& more) {
    camera_yaml(more);
    return open_error({.camera_file = folder / "camera.yaml"});
  };
  EXPECT_THAT(error(""), AllOf(HasSubstr("camera.yaml"), HasSubstr("baseline")));
  EXPECT_THAT(error("baseline: 0.1\nmodel: brown_conrady\ndistortion: [0.1, 0, 0, 0]\n"),
              AllOf(HasSubstr("camera.yaml"), HasSubstr("rectified")));
  write("calib.txt", "P0: 50 0 32 0 0 50 24 0 0 0 1 0\nP1: 50 0 32 25 0 50 24 0 0 0 1 0\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("calib.txt"), HasSubstr("not to the right")));
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
  fs::remove_all(folder / "mav0/cam1");
  EXPECT_THAT(open_error({.sensor = Sensor::stereo}), AllOf(HasSubstr("cam1"), HasSubstr("--sensor mono")));
  fs::remove(folder / "mav0/cam0/sensor.yaml");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("sensor.yaml"), HasSubstr("--camera")));
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

TEST_F(BadInput, VideosAndCameras) {
  camera_yaml();
  const SequenceOptions options{.camera_file = folder / "camera.yaml"};
  write("video.mp4", "hello");
  const auto error = [](const std::string& path, const SequenceOptions& o) {
    const auto opened = open_sequence(path, o);
    return opened ? "" : opened.error().message;
  };
  const std::string video = (folder / "video.mp4").string();
  EXPECT_THAT(error(video, options), AllOf(HasSubstr("video.mp4"), HasSubstr("not a video")));
  EXPECT_THAT(error(video, {}), AllOf(HasSubstr("video.mp4"), HasSubstr("--camera")));
  EXPECT_THAT(error(video, {.sensor = Sensor::stereo}), HasSubstr("--sensor mono only"));
  EXPECT_THAT(error("987", options), HasSubstr("the camera can't be opened"));
  EXPECT_THAT(error("webcam", {.kind = SequenceKind::camera, .camera_file = options.camera_file}),
              HasSubstr("named by its number"));
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
