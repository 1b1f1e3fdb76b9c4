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

}  // namespace
}  // namespace covis::io
