// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/nerfstudio.h"

#include <cstring>
#include <nlohmann/json.hpp>

#include "covis/exchange/test_scene.h"

namespace covis::exchange {
namespace {

TEST(Nerfstudio, ItsCamerasProjectTheCloudToTheKeypoints) {
  const TemporaryFolder folder;
  Scene scene = ring_scenes()[0];
  scene.views[2].image.clear();
  ASSERT_TRUE(write_nerfstudio(folder.path(), "transforms", scene, "images"));
  const auto json = nlohmann::json::parse(read_file(folder / "transforms.json"));
  ASSERT_EQ(json["frames"].size(), scene.views.size() - 1) << "without an image there is nothing to train on";
  EXPECT_EQ(json["frames"][0]["file_path"], "images/000000.png");
  EXPECT_EQ(json["ply_file_path"], "transforms.ply");
  const std::string cloud = read_file(folder / "transforms.ply");
  const char* first = cloud.data() + cloud.find("end_header\n") + 11;
  constexpr size_t kPoint = 6 * sizeof(float) + 3;  // with a normal and a colour
  ASSERT_EQ(static_cast<size_t>(cloud.data() + cloud.size() - first), kPoint * scene.points.size());
  double height = 0;
  for (const SceneView::Keypoint& keypoint : scene.views[0].keypoints) {
    Eigen::Vector3f at;
    std::memcpy(at.data(), first + kPoint * keypoint.point, sizeof at);
    Eigen::Matrix4d T;
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c)
        T(r, c) = json["frames"][0]["transform_matrix"][static_cast<size_t>(r)][static_cast<size_t>(c)];
    }
    const Eigen::Vector3d p = (T.inverse() * at.cast<double>().homogeneous()).head<3>();  // looks along -z, y up
    EXPECT_NEAR(json["fl_x"].get<double>() * p.x() / -p.z() + json["cx"].get<double>(), keypoint.u + 0.5, 1e-2);
    EXPECT_NEAR(json["fl_y"].get<double>() * -p.y() / -p.z() + json["cy"].get<double>(), keypoint.v + 0.5, 1e-2);
    height = std::max(height, std::abs(at.z() + scene.points[keypoint.point].position.y()));
  }
  EXPECT_LT(height, 1e-5) << "z is up, where y was down";
}

}  // namespace
}  // namespace covis::exchange
