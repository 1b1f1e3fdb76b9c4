// SPDX-License-Identifier: Apache-2.0
// The scale of a map made with a depth camera: with exact depth it must equal that of the world.
#include <gtest/gtest.h>

#include <vector>

#include "covis/geometry/alignment.h"
#include "rendered.h"

namespace covis {
namespace {

// A walk forwards through a hall of posters, door frames and skirtings, with corners of outlines in every view. Using
// the depth of the background behind those corners made the path longer by half a percent.
TEST(DepthScale, OutlinesDoNotMakeThePathLonger) {
  Recording recording(Sensor::rgbd, 40, 6, "posters", {640, 480});
  System system(recording.synth.camera(), options_for(Sensor::rgbd));
  for (int i = 0; i < recording.size(); ++i) system.process(recording.frame(i));
  system.finish();
  std::vector<Eigen::Vector3d> estimated, exact;
  for (const PoseOfFrame& pose : system.trajectory()) {
    estimated.push_back(pose.T_wc.t());
    exact.push_back(recording.synth.T_wc(static_cast<int>(pose.frame)).t());
  }
  ASSERT_EQ(static_cast<int>(estimated.size()), recording.size());
  const auto alignment = align(estimated, exact, Scale::free);
  ASSERT_TRUE(alignment);
  EXPECT_NEAR(alignment->scale, 1, 0.003);
  EXPECT_LT(align(estimated, exact, Scale::fixed)->rmse, 0.006);
}

}  // namespace
}  // namespace covis
