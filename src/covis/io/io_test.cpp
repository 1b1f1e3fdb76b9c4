// SPDX-License-Identifier: Apache-2.0
// Recordings of every layout, and what is said of bad ones.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "covis/io/camera_file.h"
#include "covis/io/config.h"
#include "covis/io/files.h"
#include "covis/io/outputs.h"
#include "covis/io/sequence.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kWidth = 64, kHeight = 48;

class Io : public testing::Test {
 protected:
  void SetUp() override {
    folder = fs::path(testing::TempDir()) / ("covis_io_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  void write(const fs::path& name, const std::string& text) const {
    fs::create_directories((folder / name).parent_path());
    std::ofstream(folder / name, std::ios::binary) << text;
  }
  void image(const fs::path& name, int grey, int width = kWidth, int height = kHeight) const {
    fs::create_directories((folder / name).parent_path());
    cv::imwrite((folder / name).string(), cv::Mat(height, width, CV_8UC3, cv::Scalar::all(grey)));
  }
  void depth(const fs::path& name, int value) const {
    fs::create_directories((folder / name).parent_path());
    cv::imwrite((folder / name).string(), cv::Mat(kHeight, kWidth, CV_16U, cv::Scalar(value)));
  }
  void camera_yaml(const std::string& more = "") const { write("camera.yaml", "width: 64\nheight: 48\nfx: 50\nfy: 50\ncx: 32\ncy: 24\n" + more); }
  void tum(int frames = 3) const {
    std::string rgb = "# colour\n", depths;
    for (int i = 0; i < frames; ++i) {
      const std::string n = std::to_string(i);
      image("rgb/" + n + ".png", 10 + i);
      depth("depth/" + n + ".png", 5000 * (i + 1));
      rgb += "1000." + n + " rgb/" + n + ".png\n";
      depths += "1000." + n + "1 depth/" + n + ".png\n";
    }
    write("rgb.txt", rgb);
    write("depth.txt", depths);
    camera_yaml();
  }
  void kitti(int frames = 3) const {
    std::string times;
    for (int i = 0; i < frames; ++i) {
      char name[32];
      std::snprintf(name, sizeof name, "%06d.png", i);
      image(fs::path("image_0") / name, 20 + i);
      image(fs::path("image_1") / name, 30 + i);
      times += std::to_string(0.1 * i) + "\n";
    }
    write("calib.txt", "P0: 50 0 32 0 0 50 24 0 0 0 1 0\nP1: 50 0 32 -25 0 50 24 0 0 0 1 0\n");
    write("times.txt", times);
  }

  Result<std::unique_ptr<Sequence>> open(SequenceOptions options = {}) const { return open_sequence(folder.string(), options); }
  std::string open_error(SequenceOptions options = {}) const {
    const auto opened = open(options);
    EXPECT_FALSE(opened);
    return opened ? "" : opened.error().message;
  }

  fs::path folder;
};

TEST_F(Io, ReadsTum) {
  tum();
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  Sequence& s = **opened;
  EXPECT_EQ(s.kind(), SequenceKind::tum);
  EXPECT_EQ(s.sensor(), Sensor::rgbd);
  EXPECT_EQ(s.size(), 3);
  EXPECT_NEAR(s.frame_rate(), 10, 1e-6);
  EXPECT_NEAR(s.camera().pinhole.baseline(), 0.08, 1e-9);
  Frame memory;
  for (int i = 0; i < 3; ++i) {
    auto frame = s.next(std::move(memory));
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->index, i);
    EXPECT_EQ((*frame)->stamp, 1000'000'000'000 + i * 100'000'000);
    EXPECT_EQ((*frame)->image(5, 5), 10 + i);
    EXPECT_FLOAT_EQ((*frame)->depth(5, 5), static_cast<float>(i + 1));
    memory = std::move(**frame);
  }
  EXPECT_FALSE(s.next()->has_value());
  EXPECT_FALSE(s.next()->has_value());
  auto mono = open({.sensor = Sensor::monocular});
  ASSERT_TRUE(mono);
  EXPECT_TRUE((*(*mono)->next())->depth.empty());
}

TEST_F(Io, ReadsTumAssociationsAndCalibration) {
  tum();
  fs::remove(folder / "camera.yaml");
  write("associations.txt", "1.5 depth/2.png 1.5 rgb/2.png\n2.5 depth/0.png 2.5 rgb/0.png\n");
  write("calibration.txt", "50 51 32 24 0.1 0.01 0 0\n");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->camera().pinhole.fy, 51);
  EXPECT_EQ((*opened)->camera().distortion, Distortion::brown_conrady);
  EXPECT_EQ((*opened)->camera().width, kWidth);
  EXPECT_EQ((*(*opened)->next())->image(1, 1), 12);
}

TEST_F(Io, ReadsKitti) {
  kitti();
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->kind(), SequenceKind::kitti);
  EXPECT_EQ((*opened)->sensor(), Sensor::stereo);
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.5, 1e-12);
  const auto frame = (*opened)->next();
  EXPECT_EQ((*frame)->image(0, 0), 20);
  EXPECT_EQ((*frame)->right(0, 0), 30);
  auto part = open({.sensor = Sensor::monocular, .first = 1, .stride = 2});
  ASSERT_TRUE(part);
  EXPECT_EQ((*part)->size(), 1);
  EXPECT_EQ((*(*part)->next())->index, 1);
}

TEST_F(Io, ReadsEurocAndRectifies) {
  const std::string sensor = "resolution: [64, 48]\nintrinsics: [50, 50, 32, 24]\ndistortion_model: radial-tangential\ndistortion_coefficients: [-0.1, 0.01, 0, 0]\n";
  for (const int cam : {0, 1}) {
    const std::string base = "mav0/cam" + std::to_string(cam);
    write(base + "/sensor.yaml", "%YAML:1.0\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, " + std::to_string(0.1 * cam) + ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n" + sensor);
    write(base + "/data.csv", "#timestamp [ns],filename\n1403715273262142976,1403715273262142976.png\n1403715273312143104,1403715273312143104.png\n");
    image(base + "/data/1403715273262142976.png", 50 + cam);
    image(base + "/data/1403715273312143104.png", 60 + cam);
  }
  write("mav0/state_groundtruth_estimate0/data.csv", "#t,x,y,z,w,x,y,z\n1403715273262142976,1,2,3,1,0,0,0,9,9,9\n");
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->sensor(), Sensor::stereo);
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), 0.1, 1e-9);
  EXPECT_EQ((*opened)->camera().distortion, Distortion::none);
  const auto frame = (*opened)->next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->stamp, 1403715273262142976);
  EXPECT_EQ((*frame)->image(32, 24), 50);
  EXPECT_EQ((*frame)->right(32, 24), 51);
  const auto truth = load_truth(**opened);
  ASSERT_TRUE(truth);
  EXPECT_NEAR(truth->front().T_wc.t().y(), 2, 1e-9);
  auto mono = open({.sensor = Sensor::monocular});
  ASSERT_TRUE(mono);
  EXPECT_EQ((*mono)->camera().distortion, Distortion::brown_conrady);
}

TEST_F(Io, ReadsAnImageFolderInNaturalOrder) {
  camera_yaml("fps: 20\n");
  for (const int i : {1, 2, 10}) image("frame" + std::to_string(i) + ".png", i);
  auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->kind(), SequenceKind::images);
  for (const int i : {1, 2, 10}) EXPECT_EQ((*(*opened)->next())->image(0, 0), i);
  EXPECT_NEAR((*opened)->frame_rate(), 20, 1e-6);
}

TEST_F(Io, ReadsAVideo) {
  camera_yaml();
  cv::VideoWriter writer((folder / "video.avi").string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, {kWidth, kHeight});
  ASSERT_TRUE(writer.isOpened());
  for (int i = 0; i < 5; ++i) writer.write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(40 * i)));
  writer.release();
  auto opened = open_sequence((folder / "video.avi").string(), {.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  int frames = 0;
  for (auto frame = (*opened)->next(); frame && *frame; frame = (*opened)->next()) {
    EXPECT_NEAR((*frame)->image(20, 20), 40 * frames, 4);
    EXPECT_EQ((*frame)->stamp, frames * 40'000'000);
    ++frames;
  }
  EXPECT_EQ(frames, 5);
}

TEST_F(Io, StopsDecodingAtAnyTime) {
  kitti(20);
  for (int k = 0; k < 30; ++k) {
    auto opened = open({.decode_ahead = 1 + k % 4});
    for (int i = 0; i < k % 5; ++i) (*opened)->next();
  }
}

// ---- Bad input ----

TEST_F(Io, MissingFolder) {
  EXPECT_THAT(open_sequence((folder / "none").string(), {}).error().message, AllOf(HasSubstr("none"), HasSubstr("does not exist")));
}

TEST_F(Io, NoImages) {
  EXPECT_THAT(open_error(), AllOf(HasSubstr(folder.string()), HasSubstr("rgb.txt"), HasSubstr("image_0"), HasSubstr("mav0")));
  fs::create_directories(folder / "image_0");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("image_0"), HasSubstr("no image")));
}

TEST_F(Io, OneTruncatedImage) {
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

TEST_F(Io, NotAnImage) {
  tum();
  write("rgb/0.png", "hello");
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr("0.png"), HasSubstr("not an image")));
  write("rgb/0.png", "");
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr("0.png"), HasSubstr("empty")));
}

TEST_F(Io, ImageOfAnotherSize) {
  tum();
  image("rgb/0.png", 1, 32, 24);
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr("0.png"), HasSubstr("32x24"), HasSubstr("64x48")));
}

TEST_F(Io, AbsentCalibration) {
  tum();
  fs::remove(folder / "camera.yaml");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("--camera"), HasSubstr("fx:")));
}

TEST_F(Io, UnreadableCalibration) {
  tum();
  write("camera.yaml", "width: [64\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera.yaml:"), HasSubstr("not YAML")));
  EXPECT_THAT(open_error({.camera_file = folder / "gone.yaml"}), AllOf(HasSubstr("gone.yaml"), HasSubstr("can't be opened")));
  kitti();
  write("calib.txt", "P0: 1 2 3\n");
  EXPECT_THAT(open_error({.kind = SequenceKind::kitti}), AllOf(HasSubstr("calib.txt:1"), HasSubstr("12")));
}

TEST_F(Io, UnknownKeyNamesTheNearest) {
  tum();
  camera_yaml("baselnie: 0.1\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("camera.yaml:7"), HasSubstr("'baselnie'"), HasSubstr("'baseline'")));
}

TEST_F(Io, ValueOutOfRangeAndNan) {
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

TEST_F(Io, StampsOutOfOrder) {
  tum();
  write("associations.txt", "2 rgb/0.png 2 depth/0.png\n1 rgb/1.png 1 depth/1.png\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("1.png"), HasSubstr("must rise")));
  kitti();
  write("times.txt", "0\n0.2\n0.1\n");
  EXPECT_THAT(open_error({.kind = SequenceKind::kitti}), AllOf(HasSubstr("000002.png"), HasSubstr("must rise")));
}

TEST_F(Io, DepthFolderEmpty) {
  tum();
  fs::remove_all(folder / "depth");
  fs::create_directories(folder / "depth");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("depth/0.png"), HasSubstr("missing")));
  write("depth.txt", "# nothing\n");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("depth.txt"), HasSubstr("no file")));
}

TEST_F(Io, StereoPairWithoutItsRightImage) {
  kitti();
  fs::remove(folder / "image_1/000001.png");
  EXPECT_THAT(open_error(), AllOf(HasSubstr("image_1/000001.png"), HasSubstr("right image"), HasSubstr("missing")));
}

TEST_F(Io, SensorTheRecordingCannotGive) {
  kitti();
  EXPECT_THAT(open_error({.sensor = Sensor::rgbd}), HasSubstr("no depth images"));
}

TEST_F(Io, FullDiskLeavesTheOldFile) {
  ASSERT_TRUE(write_text_atomically(folder / "out.txt", "old"));
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 1000;
  setrlimit(RLIMIT_FSIZE, &small);
  const auto written = write_text_atomically(folder / "out.txt", std::string(5000, 'x'));
  setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, AllOf(HasSubstr("out.txt"), HasSubstr("can't be written")));
  EXPECT_EQ(*read_text(folder / "out.txt"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1) << "a temporary file is left";
  EXPECT_THAT(write_text_atomically(folder / "no/out.txt", "x").error().message, HasSubstr("no/out.txt"));
  EXPECT_TRUE(write_ply(folder / "map.ply", {{1, 2, 3}}));
  EXPECT_THAT(*read_text(folder / "map.ply"), HasSubstr("element vertex 1"));
}

// ---- Settings, cameras, trajectories ----

TEST_F(Io, SettingsRoundTripAndComplain) {
  int count = 3;
  double ratio = 0.5;
  const Fields fields{{"a.count", &count, "how many", 1, 10}, {"a.ratio", &ratio, "share", 0, 1}};
  count = 7;
  write("s.yaml", dump_settings(fields));
  count = 1;
  ASSERT_TRUE(load_settings(folder / "s.yaml", fields));
  EXPECT_EQ(count, 7);
  write("s.yaml", "a:\n  count: 2\n  rtaio: 0.1\n");
  EXPECT_THAT(load_settings(folder / "s.yaml", fields).error().message, AllOf(HasSubstr("s.yaml:3"), HasSubstr("a.rtaio"), HasSubstr("'a.ratio'")));
  write("s.yaml", "a.count: 99\n");
  EXPECT_THAT(load_settings(folder / "s.yaml", fields).error().message, AllOf(HasSubstr("s.yaml:1"), HasSubstr("'99'"), HasSubstr("from 1 to 10")));
}

TEST_F(Io, CamerasRoundTrip) {
  CameraFile file;
  file.camera.width = 640;
  file.camera.height = 480;
  file.camera.pinhole = {500.5, 501, 320, 240, 0};
  file.camera.distortion = Distortion::kannala_brandt;
  file.camera.coefficients = {0.1, 0.01, 0.001, 0.0001, 0};
  file.baseline = 0.11;
  file.fps = 30;
  write("c.yaml", camera_text(file));
  const auto loaded = load_camera(folder / "c.yaml");
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(loaded->camera.pinhole.fx, 500.5);
  EXPECT_EQ(loaded->camera.coefficients, file.camera.coefficients);
  EXPECT_NEAR(loaded->camera.pinhole.baseline(), 0.11, 1e-12);
  for (const auto& entry : fs::directory_iterator(fs::path(COVIS_SOURCE_DIR) / "cameras")) {
    EXPECT_TRUE(load_camera(entry.path())) << entry.path();
  }
}

TEST_F(Io, TrajectoriesRoundTripExactly) {
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
  write("bad.txt", "# t\n1 2 3\n");
  EXPECT_THAT(read_trajectory(folder / "bad.txt").error().message, HasSubstr("bad.txt:2"));
  write("bad.txt", "1 0 0 0 0 0 0 nan\n");
  EXPECT_FALSE(read_trajectory(folder / "bad.txt"));
  write("bad.txt", "1 0 0 0 0 0 0 7\n");
  EXPECT_THAT(read_trajectory(folder / "bad.txt").error().message, HasSubstr("rotation"));
}

TEST(Stamps, AreExact) {
  EXPECT_EQ(parse_stamp("1305031102.175304"), 1305031102175304000);
  EXPECT_EQ(parse_stamp("1403715273262142976"), 1403715273262142976);
  EXPECT_EQ(parse_stamp("12"), 12'000'000'000);
  EXPECT_EQ(parse_stamp("1.5e0"), 1'500'000'000);
  EXPECT_EQ(parse_stamp("-0.25"), -250'000'000);
  EXPECT_FALSE(parse_stamp("x"));
  EXPECT_FALSE(parse_stamp("nan"));
  EXPECT_EQ(stamp_text(1305031102175304000), "1305031102.175304000");
  EXPECT_EQ(stamp_text(-250'000'000), "-0.250000000");
}

}  // namespace
}  // namespace covis::io
