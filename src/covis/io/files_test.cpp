// SPDX-License-Identifier: Apache-2.0
// Files in and out: stamps, trajectories, point clouds, a full disk.
#include "covis/io/files.h"

#include <cstring>

#include "covis/core/random.h"
#include "covis/io/outputs.h"
#include "covis/io/test_recordings.h"
#include "covis/io/trajectory.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Files : public RecordingTest {};

TEST_F(Files, ReadWhole) {
  const std::string bytes("one\0two\n", 8);
  write("some", bytes);
  EXPECT_EQ(*read_text(folder / "some"), bytes);
  std::string memory(100, 'x');
  ASSERT_TRUE(read_bytes(folder / "some", memory));
  EXPECT_EQ(memory, bytes);
  EXPECT_THAT(*read_text("/proc/self/status"), HasSubstr("Pid:")) << "a file whose size is not known before";
  EXPECT_THAT(read_text(folder).error().message, HasSubstr("it is a folder"));
  EXPECT_THAT(read_text(folder / "none").error().message, HasSubstr("none: it can't be opened"));
}

TEST_F(Files, FullDiskIsAnErrorOfATrajectory) {
  fs::create_symlink("/dev/full", folder / "full");
  Trajectory one(1);
  EXPECT_THAT(write_trajectory(folder / "full", one, TrajectoryFormat::tum).error().message,
              HasSubstr("No space left"));
}

TEST_F(Files, PointCloudsHoldEveryPoint) {
  const std::vector<Eigen::Vector3d> points{{1, 2, 3}, {-0.5, 1e-3, 7e4}};
  ASSERT_TRUE(write_ply(folder / "map.ply", points));
  const std::string text = *read_text(folder / "map.ply");
  EXPECT_THAT(text, AllOf(testing::StartsWith("ply\nformat binary_little_endian 1.0\n"),
                          HasSubstr("element vertex 2\nproperty float x\nproperty float y\nproperty float z\n")));
  const size_t body = text.find("end_header\n") + 11;
  ASSERT_EQ(text.size(), body + 2 * 3 * sizeof(float));
  for (size_t i = 0; i < 6; ++i) {
    float value;
    std::memcpy(&value, text.data() + body + i * sizeof value, sizeof value);
    EXPECT_EQ(value, static_cast<float>(points[i / 3][static_cast<Eigen::Index>(i % 3)]));
  }
}

TEST_F(Files, TrajectoriesRoundTripExactly) {
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

TEST(Stamps, AreReadHoweverTheyAreWritten) {
  EXPECT_EQ(parse_stamp("1.036000e-01"), 103'600'000);
  EXPECT_EQ(parse_stamp("1.403715273262142976e+18"), 1403715273262142976) << "nanoseconds with an exponent";
  EXPECT_EQ(parse_stamp("1403715273262142976.000000"), 1403715273262142976) << "nanoseconds with decimals";
  EXPECT_EQ(parse_stamp("1403715273.262142976"), 1403715273262142976);
  EXPECT_EQ(parse_stamp("0.29999999999999999"), 300'000'000) << "rounded, not cut";
  EXPECT_EQ(parse_stamp("0.9999999996"), 1'000'000'000);
  EXPECT_EQ(parse_stamp("-0.9999999996"), -1'000'000'000);
  EXPECT_EQ(parse_stamp("1e-10"), 0);
  EXPECT_EQ(parse_stamp("6e-10"), 1);
  EXPECT_EQ(parse_stamp("1e-300"), 0);
  EXPECT_EQ(parse_stamp("000000.5"), 500'000'000);
  EXPECT_EQ(parse_stamp("0"), 0);
  EXPECT_EQ(parse_stamp("+.5"), 500'000'000);
  EXPECT_EQ(parse_stamp("12", WholeStamp::nanoseconds), 12);
  EXPECT_EQ(parse_stamp("12.0", WholeStamp::nanoseconds), 12'000'000'000);
  for (const char* text : {"", "-", "+", ".", "e5", "1e", "1.2.3", "0x10", "12s", "inf", "1e300",
                           "99999999999999999999", "100000000000"}) {
    EXPECT_FALSE(parse_stamp(text)) << text;
  }
}

TEST(Stamps, GoThroughTextUnchanged) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const auto stamp = static_cast<Timestamp>(random.next() >> (1 + random.below(60))) * (random.below(2) ? 1 : -1);
    EXPECT_EQ(parse_stamp(stamp_text(stamp)), stamp);
    EXPECT_EQ(parse_stamp(std::to_string(stamp), WholeStamp::nanoseconds), stamp);
  }
}

}  // namespace
}  // namespace covis::io
