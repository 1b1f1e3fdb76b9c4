// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>

#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "covis/io/test_recordings.h"
#include "covis/io/video_file.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST_F(Sequences, ReadsAVideo) {
  camera_yaml();
  cv::VideoWriter writer((folder / "video.avi").string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25,
                         {kWidth, kHeight});
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

TEST_F(Sequences, ReadsTheUsualContainers) {
  camera_yaml();
  for (const auto& [name, codec] : {std::pair{"a.mp4", "mp4v"},
                                    {"a.mov", "mp4v"},
                                    {"a.mkv", "MJPG"},
                                    {"a.webm", "VP80"},
                                    {"a.avi", "XVID"},
                                    {"a.ts", "MPG2"},
                                    {"a.mpg", "MPG1"},
                                    {"a.flv", "FLV1"},
                                    {"a.wmv", "WMV2"},
                                    {"a.mjpeg", "MJPG"}}) {
    const std::string video = (folder / name).string();
    cv::VideoWriter writer(video, cv::CAP_FFMPEG, cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]), 25,
                           {kWidth, kHeight});
    if (!writer.isOpened()) continue;  // FFmpeg was built without it
    for (int i = 0; i < 30; ++i) writer.write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(100)));
    writer.release();
    const auto opened = open_sequence(video, {.camera_file = folder / "camera.yaml"});
    ASSERT_TRUE(opened) << opened.error().message;
    const auto frame = (*opened)->next();
    ASSERT_TRUE(frame && *frame) << name;
    EXPECT_NEAR((*frame)->image(20, 20), 100, 4) << name;
    RecordProperty(name, "read");
  }
}

// FFmpeg knows JPEG files in a row under another name where they have the header of a JPEG file.
TEST_F(Sequences, ReadsJpegFilesInARow) {
  camera_yaml();
  std::string all;
  for (int i = 0; i < 10; ++i) {
    std::vector<uint8_t> bytes;
    cv::imencode(".jpg", cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(20 * i)), bytes);
    all.append(bytes.begin(), bytes.end());
  }
  write("a.mjpg", all);
  const auto opened = open_sequence((folder / "a.mjpg").string(), {.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  int frames = 0;
  for (auto frame = (*opened)->next(); frame && *frame; frame = (*opened)->next()) {
    EXPECT_NEAR((*frame)->image(20, 20), 20 * frames, 2);
    ++frames;
  }
  EXPECT_EQ(frames, 10);
}

TEST_F(Sequences, AVideoThatEndsBeforeTheFirstFrameSaysSo) {
  camera_yaml();
  const std::string video = (folder / "video.avi").string();
  cv::VideoWriter writer(video, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, {kWidth, kHeight});
  for (int i = 0; i < 3; ++i) writer.write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(40 * i)));
  writer.release();
  const auto opened = open_sequence(video, {.camera_file = folder / "camera.yaml", .first = 500});
  ASSERT_TRUE(opened) << opened.error().message;
  const auto frame = (*opened)->next();
  ASSERT_FALSE(frame);
  EXPECT_THAT(frame.error().message, HasSubstr("video.avi: it has 3 frames; none is left from frame 500 on"));
  const auto after = (*opened)->next();
  ASSERT_TRUE(after) << "who goes on after an error comes to an end";
  EXPECT_FALSE(*after);
}

TEST_F(Sequences, AVideoOpenedUncalibratedHasASizeAlone) {
  const std::string video = (folder / "video.avi").string();
  cv::VideoWriter writer(video, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, {kWidth, kHeight});
  for (int i = 0; i < 3; ++i) writer.write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(40 * i)));
  writer.release();
  const auto opened = open_sequence(video, {.uncalibrated = true});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->camera().width, kWidth);
  EXPECT_EQ((*opened)->camera().height, kHeight);
  EXPECT_EQ((*opened)->camera().pinhole.fx, 0);
  EXPECT_TRUE((*opened)->next()->has_value());
  EXPECT_FALSE(open_sequence("987", {.uncalibrated = true})) << "a camera's images can't be looked at twice";
}

TEST_F(Sequences, TakesAPartOfAVideo) {
  camera_yaml("fps: 10\n");
  cv::VideoWriter writer((folder / "video.avi").string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25,
                         {kWidth, kHeight});
  for (int i = 0; i < 9; ++i) writer.write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(20 * i)));
  writer.release();
  auto opened = open_sequence((folder / "video.avi").string(),
                              {.camera_file = folder / "camera.yaml", .first = 1, .count = 2, .stride = 3});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->size(), 2);
  EXPECT_NEAR((*opened)->frame_rate(), 10.0 / 3, 1e-9) << "that of the frames it gives, as of a folder";
  EXPECT_FALSE(doubt_about_rate(**opened, 3));
  for (const int i : {1, 4}) {
    const auto frame = (*opened)->next();
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->index, i);
    EXPECT_EQ((*frame)->stamp, i * 100'000'000);
    EXPECT_NEAR((*frame)->image(20, 20), 20 * i, 4);
  }
  EXPECT_FALSE((*opened)->next()->has_value());
  for (const int i : {4, 7, 1, 1}) {  // forward and back
    const auto picture = (*opened)->picture(i);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_TRUE(picture->coloured());
    EXPECT_NEAR(picture->row(20)[60], 20 * i, 4);
  }
  EXPECT_FALSE((*opened)->picture(9));
}

TEST_F(BadInput, AVideoThatEndsBeforeItsTimeSaysSo) {
  camera_yaml();
  const fs::path video = folder / "video.avi";
  cv::VideoWriter writer(video.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, {kWidth, kHeight});
  cv::Mat image(kHeight, kWidth, CV_8UC3);
  cv::RNG random(1);
  for (int i = 0; i < 8; ++i) {
    random.fill(image, cv::RNG::UNIFORM, 0, 255);
    writer.write(image);
  }
  writer.release();
  fs::resize_file(video, fs::file_size(video) / 2);
  const auto opened = open_sequence(video.string(), {.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  int frames = 0, damaged = 0;  // the last one is cut
  auto next = (*opened)->next();
  for (; !next || *next; next = (*opened)->next(), ++frames) damaged += !next;
  EXPECT_GT(frames, 1);
  EXPECT_LE(damaged, 1);
  ASSERT_TRUE(next) << "a container may promise what it does not know: " << next.error().message;
  EXPECT_TRUE((*opened)->next());
  EXPECT_THAT((*opened)->notes(),
              testing::ElementsAre(AllOf(HasSubstr("video.avi"),
                                         HasSubstr("promises 8 frames, and " + std::to_string(frames) + " came"))));
}

// Writes JPEG files as the frames of an AVI file, 25 in a second.
std::string avi_of(const std::vector<std::string>& frames) {
  const auto number = [](size_t value) {
    return std::string{static_cast<char>(value), static_cast<char>(value >> 8), static_cast<char>(value >> 16), '\0'};
  };
  const auto piece = [&](const std::string& name, const std::string& data) {
    return name + number(data.size()) + data + std::string(data.size() % 2, '\0');
  };
  const auto list = [&](const std::string& name, const std::string& data) { return piece("LIST", name + data); };
  const auto numbers = [&](const std::vector<size_t>& values) {
    std::string bytes;
    for (const size_t value : values) bytes += number(value);
    return bytes;
  };
  std::string pictures, index;
  for (const std::string& frame : frames) {
    index += "00dc" + numbers({16, 4 + pictures.size(), frame.size()});
    pictures += piece("00dc", frame);
  }
  const std::string header = numbers({40000, 0, 0, 16, frames.size(), 0, 1, 0, kWidth, kHeight, 0, 0, 0, 0});
  const std::string stream =
      "vidsMJPG" + numbers({0, 0, 0, 1, 25, 0, frames.size(), 0, 0, 0}) + numbers({0, kWidth | kHeight << 16});
  const std::string format = numbers({40, kWidth, kHeight, 1 | 24 << 16}) + "MJPG" + numbers({0, 0, 0, 0, 0});
  const std::string heads = piece("avih", header) + list("strl", piece("strh", stream) + piece("strf", format));
  return piece("RIFF", "AVI " + list("hdrl", heads) + list("movi", pictures) + piece("idx1", index));
}

// The decoder would give the frame before, or parts of it, in their place.
TEST_F(BadInput, AFrameOfMotionJpegThatIsDamagedOrOfAnotherSizeIsReported) {
  camera_yaml();
  const auto jpeg = [](int grey, int width = kWidth, int height = kHeight) {
    std::vector<uint8_t> bytes;
    cv::Mat image(height, width, CV_8UC3);
    cv::RNG(1).fill(image, cv::RNG::UNIFORM, grey, grey + 20);
    cv::imencode(".jpg", image, bytes);
    return std::string(bytes.begin(), bytes.end());
  };
  std::vector<std::string> frames;
  for (int i = 0; i < 8; ++i) frames.push_back(jpeg(20 * i));
  frames[2].resize(frames[2].size() / 2);
  frames[4] = jpeg(80, 2 * kWidth, 2 * kHeight);
  frames[6] = "none";
  write("video.avi", avi_of(frames));
  const auto opened = open_sequence((folder / "video.avi").string(), {.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(opened) << opened.error().message;
  std::vector<int> greys;  // -1: it can't be decoded
  for (auto frame = (*opened)->next(); !frame || *frame; frame = (*opened)->next())
    greys.push_back(frame ? (*frame)->image(20, 20) / 20 : -1);
  EXPECT_EQ(greys, (std::vector<int>{0, 1, -1, 3, -1, 5, -1, 7}));
  EXPECT_THAT((*opened)->picture(2).error().message, HasSubstr("frame 2 can't be decoded"));
  // If the first is no whole JPEG file, the decoder alone knows.
  frames[0].resize(frames[0].size() - 2);
  write("video.avi", avi_of(frames));
  const auto others = open_sequence((folder / "video.avi").string(), {.camera_file = folder / "camera.yaml"});
  ASSERT_TRUE(others && (*others)->next());
}

TEST_F(BadInput, AVideoThatCantBeReadSaysWhy) {
  EXPECT_THAT(open_video_file((folder / "none.mp4").string()).error().message,
              AllOf(HasSubstr("none.mp4"), HasSubstr("No such file")));
  EXPECT_THAT(open_video_file("/dev/zero").error().message, HasSubstr("it is a pipe or a device"));
}

TEST(VideoFile, TheUsersOptionsOfFfmpegKeepItsLimits) {
  const std::string limits = limited_ffmpeg_options("");
  EXPECT_THAT(limits, AllOf(HasSubstr("protocol_whitelist;file|"), HasSubstr("format_whitelist;mov,")));
  EXPECT_EQ(limited_ffmpeg_options("threads;1"), limits + "|threads;1|" + limits);
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
  ASSERT_EQ(mkfifo((folder / "pipe.mp4").c_str(), 0600), 0);
  EXPECT_THAT(error((folder / "pipe.mp4").string(), options), HasSubstr("pipe.mp4: it is no regular file"));
  // Playlists, a script, a description of a stream and an animation, in what may be taken for a video by its name.
  for (const char* text : {"#EXTM3U\n#EXTINF:1,\n/dev/zero\n", "ffconcat version 1.0\nfile '/dev/zero'\n", "<MPD>\n",
                           "v=0\nm=video 5000 RTP/AVP 96\nc=IN IP4 127.0.0.1\n", "GIF89a\1\0\1\0\0\0\0;"}) {
    write("video.mp4", text);
    EXPECT_THAT(error(video, options), AllOf(HasSubstr("video.mp4"), HasSubstr("not a video"))) << text;
  }
  write("video.mp4", std::string(1 << 16, '\xff').replace(1, 1, "\xd8") + "\nc=IN IP4 127.0.0.1\n");
  EXPECT_THAT(error(video, options), HasSubstr("not a video")) << "FFmpeg may not take another kind than those known";
  EXPECT_EQ(std::getenv("OPENCV_FFMPEG_CAPTURE_OPTIONS"), limited_ffmpeg_options("")) << "it stays";
  EXPECT_THAT(error("987", options), HasSubstr("the camera can't be opened"));
  EXPECT_THAT(error("webcam", {.kind = SequenceKind::camera, .camera_file = options.camera_file}),
              HasSubstr("named by its number"));
}

}  // namespace
}  // namespace covis::io
