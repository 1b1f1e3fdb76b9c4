// SPDX-License-Identifier: Apache-2.0
#include "synth/sequence_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "covis/core/test_folder.h"
#include "covis/io/sequence.h"

namespace covis {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class SequenceWriter : public testing::Test {
 protected:
  static Synth make(const std::string& sensor, int frames, double distortion = 0) {
    SynthOptions options;
    options.world = "room";
    options.sensor = sensor;
    options.width = 160;
    options.height = 120;
    options.frames = frames;
    options.distortion = distortion;
    return std::move(Synth::create(options).value());
  }

  const TemporaryFolder temporary_;
  const fs::path folder_ = temporary_ / "recording";
};

// Checks that the recording read back equals the rendered one: images, stamps, camera and ground truth.
void expect_read_back(Synth& synth, const fs::path& folder, io::SequenceKind kind) {
  const auto sequence = io::open_sequence(folder.string(), {});
  ASSERT_TRUE(sequence) << sequence.error().message;
  EXPECT_EQ((*sequence)->kind(), kind);
  EXPECT_EQ((*sequence)->sensor(), synth.sensor());
  EXPECT_EQ((*sequence)->size(), synth.frames());
  const Camera &read = (*sequence)->camera(), &made = synth.camera();
  EXPECT_EQ(read.width, made.width);
  EXPECT_EQ(read.distortion, made.distortion);
  EXPECT_EQ(read.coefficients, made.coefficients);
  EXPECT_NEAR(read.pinhole.fx, made.pinhole.fx, 1e-9);
  EXPECT_NEAR(read.pinhole.cy, made.pinhole.cy, 1e-9);
  EXPECT_NEAR(read.pinhole.bf, made.pinhole.bf, 1e-9);
  ImageU8 left, right;
  ImageF depth;
  for (int i = 0; i < synth.frames(); ++i) {
    const auto next = (*sequence)->next();
    ASSERT_TRUE(next) << next.error().message;
    ASSERT_TRUE(*next);
    const io::Frame& frame = **next;
    EXPECT_EQ(frame.stamp, synth.stamp(i));
    synth.render(i, left, &right, &depth);
    for (int y = 0; y < made.height; ++y) {
      for (int x = 0; x < made.width; ++x) {
        ASSERT_EQ(frame.image(x, y), left(x, y));
        if (synth.sensor() == Sensor::stereo) {
          ASSERT_EQ(frame.right(x, y), right(x, y));
        }
        if (synth.sensor() == Sensor::rgbd) {
          ASSERT_NEAR(frame.depth(x, y), depth(x, y), 1.01e-4);
        }
      }
    }
  }
  ASSERT_TRUE((*sequence)->truth());
  const auto poses = io::load_truth(**sequence);
  ASSERT_TRUE(poses) << poses.error().message;
  ASSERT_EQ(poses->size(), static_cast<size_t>(synth.frames()));
  for (int i = 0; i < synth.frames(); ++i) {
    const StampedPose& pose = (*poses)[static_cast<size_t>(i)];
    EXPECT_EQ(pose.stamp, synth.stamp(i));
    // As seen from the first frame, so that it does not matter which world frame the layout wants.
    const SE3 relative = (*poses)[0].T_wc.inverse() * pose.T_wc, wanted = synth.T_wc(0).inverse() * synth.T_wc(i);
    EXPECT_LT((relative.inverse() * wanted).log().norm(), 1e-6);
  }
}

TEST_F(SequenceWriter, RgbdIsATumFolder) {
  Synth synth = make("rgbd", 3, 0.5);
  const auto report = write_sequence(synth, folder_, Existing::refuse, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->frames, 3);
  EXPECT_GT(report->bytes, 10000u);
  expect_read_back(synth, folder_, io::SequenceKind::tum);
}

TEST_F(SequenceWriter, StereoIsAKittiFolder) {
  Synth synth = make("stereo", 3);
  const auto report = write_sequence(synth, folder_, Existing::refuse, {});
  ASSERT_TRUE(report) << report.error().message;
  expect_read_back(synth, folder_, io::SequenceKind::kitti);
}

TEST_F(SequenceWriter, MonoIsAnImageFolder) {
  Synth synth = make("mono", 4, 1);
  const auto report = write_sequence(synth, folder_, Existing::refuse, {});
  ASSERT_TRUE(report) << report.error().message;
  expect_read_back(synth, folder_, io::SequenceKind::images);
}

TEST_F(SequenceWriter, KeepsWhatIsThereUnlessToldToReplaceIt) {
  Synth stereo = make("stereo", 4), rgbd = make("rgbd", 2);
  ASSERT_TRUE(write_sequence(stereo, folder_, Existing::refuse, {}));
  const auto refused = write_sequence(rgbd, folder_, Existing::refuse, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("not empty"));
  EXPECT_TRUE(fs::exists(folder_ / "image_1"));
  std::ofstream(folder_ / "mine.txt") << "kept";
  ASSERT_TRUE(write_sequence(rgbd, folder_, Existing::replace, {}));
  EXPECT_FALSE(fs::exists(folder_ / "image_1"));
  EXPECT_TRUE(fs::exists(folder_ / "mine.txt"));
  expect_read_back(rgbd, folder_, io::SequenceKind::tum);
}

// --overwrite in a folder of real images removed them.
TEST_F(SequenceWriter, ReplacesNoRecordingOfOthers) {
  fs::create_directories(folder_ / "rgb");
  std::ofstream(folder_ / "rgb" / "1.png") << "a photograph";
  Synth rgbd = make("rgbd", 2);
  const auto refused = write_sequence(rgbd, folder_, Existing::replace, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("covis synth did not make what is in it (it has no synth.json)"));
  EXPECT_TRUE(fs::exists(folder_ / "rgb" / "1.png"));
}

TEST_F(SequenceWriter, SaysThatTheFolderCannotBeMade) {
  Synth synth = make("mono", 1);
  fs::create_directories(folder_);
  std::ofstream(folder_ / "file") << "x";
  const auto report = write_sequence(synth, folder_ / "file" / "inside", Existing::refuse, {});
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, HasSubstr("can't be made"));
}

TEST_F(SequenceWriter, SaysThatAFileCannotBeWritten) {
  Synth synth = make("rgbd", 3);
  // A limit on the size of files stands for a full disk.
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit old_limit{}, limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  limit = old_limit;
  limit.rlim_cur = 4096;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  const auto report = write_sequence(synth, folder_, Existing::refuse, {});
  setrlimit(RLIMIT_FSIZE, &old_limit);
  std::signal(SIGXFSZ, old_handler);
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, HasSubstr(".png"));
  EXPECT_THAT(report.error().message, HasSubstr("can't be written"));
}

TEST_F(SequenceWriter, StopsWhenToldTo) {
  Synth synth = make("mono", 50);
  int most = 0;
  const auto report = write_sequence(synth, folder_, Existing::refuse, [&](int done) {
    most = done;
    return done < 3;
  });
  ASSERT_FALSE(report);
  EXPECT_EQ(most, 3);
  EXPECT_THAT(report.error().message, HasSubstr("stopped after 3 of 50"));
}

}  // namespace
}  // namespace covis
