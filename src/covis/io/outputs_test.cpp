// SPDX-License-Identifier: Apache-2.0
#include "covis/io/outputs.h"

#include <cstring>

#include "covis/io/files.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Outputs : public RecordingTest {};

TEST_F(Outputs, PointCloudsHoldEveryPoint) {
  const std::vector<CloudPoint> points{{{1, 2, 3}}, {{-0.5, 1e-3, 7e4}}};
  ASSERT_TRUE(write_ply(folder / "map.ply", points));
  const std::string text = *read_text(folder / "map.ply");
  EXPECT_THAT(text, AllOf(testing::StartsWith("ply\nformat binary_little_endian 1.0\n"),
                          HasSubstr("comment map points, metres\n"),
                          HasSubstr("element vertex 2\nproperty float x\nproperty float y\nproperty float z\n")));
  const size_t body = text.find("end_header\n") + 11;
  ASSERT_EQ(text.size(), body + 2 * 3 * sizeof(float));
  for (size_t i = 0; i < 6; ++i) {
    float value;
    std::memcpy(&value, text.data() + body + i * sizeof value, sizeof value);
    EXPECT_EQ(value, static_cast<float>(points[i / 3].position[static_cast<Eigen::Index>(i % 3)]));
  }
}

TEST_F(Outputs, PointCloudsSayTheirUnit) {
  ASSERT_TRUE(write_ply(folder / "map.ply", {}, CloudUnit::of_map));
  EXPECT_THAT(*read_text(folder / "map.ply"), HasSubstr("comment map points, units of the map\n"));
}

TEST_F(Outputs, PointCloudsHoldNormalsAndColoursWhereThereAreAny) {
  ASSERT_TRUE(write_ply(folder / "map.ply", {{{1, 2, 3}, {200, 100, 50}, {0, 0, -1}}, {{4, 5, 6}}}));
  const std::string text = *read_text(folder / "map.ply");
  EXPECT_THAT(
      text, HasSubstr("property float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header"));
  const size_t body = text.find("end_header\n") + 11;
  ASSERT_EQ(text.size(), body + 2 * (6 * sizeof(float) + 3));
  float nz;
  std::memcpy(&nz, text.data() + body + 5 * sizeof nz, sizeof nz);
  EXPECT_EQ(nz, -1);
  EXPECT_EQ(text.substr(body + 6 * sizeof nz, 3), "\xc8\x64\x32");
  EXPECT_EQ(text.substr(text.size() - 3), "\x80\x80\x80") << "grey where the colour is not known";
}

}  // namespace
}  // namespace covis::io
