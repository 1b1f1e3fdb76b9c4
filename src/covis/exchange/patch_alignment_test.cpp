// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/patch_alignment.h"

#include <algorithm>
#include <cmath>

#include "covis/exchange/test_scene.h"
#include "covis/io/images.h"

namespace covis::exchange {
namespace {

constexpr double kDepth = 4;  // of the painted wall, metres

// Grey of the wall, smooth and nowhere the same again.
double paint(double x, double y) {
  const double a = std::sin(31 * x + 4 * std::sin(17 * y)), b = std::sin(29 * y + 3 * std::sin(23 * x + 1));
  return 128 + 55 * a + 55 * b;
}

// Three views of a wall: from the middle, from the side and from nearer, with points on it where the first sees them.
class PatchAlignment : public testing::Test {
 protected:
  PatchAlignment() {
    const Camera camera{160, 120, {150, 150, 79.5, 59.5}, Distortion::none, {}};
    scene.cameras = {{camera, camera.pinhole, camera.pinhole}};
    const Eigen::Vector3d centres[] = {{0, 0, 0}, {0.3, 0.05, 0}, {-0.1, 0, 1}};
    for (uint32_t v = 0; v < 3; ++v) {
      SceneView& view = scene.views.emplace_back();
      view.serial = v;
      view.image = image_name(v);
      view.T_cw = SE3(Eigen::Matrix3d::Identity(), -centres[v]);
      write(v);
    }
    for (int k = 0; k < 12; ++k) {
      ScenePoint& point = scene.points.emplace_back();
      point.position = kDepth * camera.pinhole.unproject(50 + 20 * (k % 4), 40 + 20 * (k / 4));
      point.normal = {0, 0, -1};
      for (SceneView& view : scene.views) {
        const Eigen::Vector2d at = camera.pinhole.project(view.T_cw * point.position);
        view.keypoints.push_back({.u = at.x(), .v = at.y(), .point = static_cast<uint32_t>(k)});
      }
    }
    find_sights(scene);
    exact = scene;
  }
  void write(uint32_t v) const {
    const SceneView& view = scene.views[v];
    const Camera& camera = scene.cameras[0].given;
    io::Picture picture{.width = camera.width, .height = camera.height, .channels = 1, .bytes = {}};
    const Eigen::Vector3d centre = view.T_cw.inverse().t();
    for (int row = 0; row < picture.height; ++row) {
      for (int column = 0; column < picture.width; ++column) {
        const Eigen::Vector3d at = centre + (kDepth - centre.z()) * camera.pinhole.unproject(column, row);
        picture.bytes.push_back(static_cast<uint8_t>(std::lround(paint(at.x(), at.y()))));
      }
    }
    ASSERT_TRUE(io::write_picture(folder / view.image, picture));
  }
  // Displaces the keypoints of all views but the first, as those of coarse levels are.
  void displace() {
    for (uint32_t v = 1; v < 3; ++v) {
      for (SceneView::Keypoint& keypoint : scene.views[v].keypoints) {
        keypoint.u += keypoint.point % 2 ? 1.2 : -0.9;
        keypoint.v += keypoint.point % 3 ? -1.1 : 0.8;
        keypoint.scale = 1.44;
      }
    }
    find_sights(scene);
  }
  double off(uint32_t v, size_t k) const {
    const SceneView::Keypoint& is = scene.views[v].keypoints[k];
    const auto& keypoints = exact.views[v].keypoints;
    const auto was =
        std::find_if(keypoints.begin(), keypoints.end(), [&](const auto& e) { return e.point == is.point; });
    return std::hypot(is.u - was->u, is.v - was->v);
  }

  const TemporaryFolder folder;
  Scene scene, exact;
};

TEST_F(PatchAlignment, FindsKeypointsToAFractionOfAPixel) {
  displace();
  EXPECT_GT(mean_error(scene), 0.9);
  const auto left_out = align_keypoints(scene, folder.path());
  ASSERT_TRUE(left_out) << left_out.error().message;
  EXPECT_EQ(*left_out, 0u);
  for (uint32_t v = 0; v < 3; ++v) {
    ASSERT_EQ(scene.views[v].keypoints.size(), 12u);
    for (size_t k = 0; k < 12; ++k) EXPECT_LT(off(v, k), 0.1) << "view " << v << ", point " << k;
  }
  EXPECT_LT(mean_error(scene), 0.05) << "the points' errors follow";
  for (size_t i = 0; i < 12; ++i) EXPECT_EQ(scene.points[i].position, exact.points[i].position);
}

// Keypoints from which a turn was taken are not where the image shows them.
TEST_F(PatchAlignment, LooksWhereARollingShutterMovedAKeypoint) {
  displace();
  const Eigen::Vector2d rolled(6, -4);
  for (SceneView& view : scene.views) {
    for (SceneView::Keypoint& keypoint : view.keypoints) {
      keypoint.rolled = rolled;
      keypoint.u -= rolled.x();
      keypoint.v -= rolled.y();
    }
  }
  const auto left_out = align_keypoints(scene, folder / "");
  ASSERT_TRUE(left_out);
  EXPECT_EQ(*left_out, 0u);
  for (uint32_t v = 0; v < 3; ++v) {
    for (size_t k = 0; k < scene.views[v].keypoints.size(); ++k) EXPECT_NEAR(off(v, k), rolled.norm(), 0.1);
  }
}

TEST_F(PatchAlignment, LeavesOutWhereTheImageShowsSomethingElse) {
  displace();
  scene.views[2].keypoints[5].u += 9;
  for (const uint32_t v : {1u, 2u}) scene.views[v].keypoints[7].v += 9;
  const double before = scene.views[2].keypoints[7].v;
  const auto left_out = align_keypoints(scene, folder.path());
  ASSERT_TRUE(left_out) << left_out.error().message;
  EXPECT_EQ(*left_out, 1u) << "point 7 is found nowhere, and stays as it was";
  EXPECT_EQ(scene.points[5].seen.size(), 2u);
  EXPECT_EQ(scene.points[7].seen.size(), 3u);
  EXPECT_EQ(scene.views[2].keypoints[6].point, 7u);
  EXPECT_EQ(scene.views[2].keypoints[6].v, before);
}

TEST_F(PatchAlignment, LeavesAloneWhatHasNoImageOrNoTexture) {
  displace();
  scene.views[2].image.clear();
  io::Picture grey{.width = 160, .height = 120, .channels = 1, .bytes = std::vector<uint8_t>(160 * 120, 90)};
  ASSERT_TRUE(io::write_picture(folder / scene.views[1].image, grey));
  const Scene before = scene;
  const auto left_out = align_keypoints(scene, folder.path());
  ASSERT_TRUE(left_out) << left_out.error().message;
  EXPECT_EQ(*left_out, 0u);
  for (uint32_t v = 0; v < 3; ++v) {
    for (size_t k = 0; k < 12; ++k) EXPECT_EQ(scene.views[v].keypoints[k].u, before.views[v].keypoints[k].u);
  }
}

TEST_F(PatchAlignment, NamesAnImageThatIsNotItsCameras) {
  io::Picture small{.width = 60, .height = 40, .channels = 1, .bytes = std::vector<uint8_t>(60 * 40, 90)};
  ASSERT_TRUE(io::write_picture(folder / scene.views[1].image, small));
  const auto aligned = align_keypoints(scene, folder.path());
  ASSERT_FALSE(aligned);
  EXPECT_THAT(aligned.error().message, testing::HasSubstr(scene.views[1].image + ": the image is 60x40"));
}

}  // namespace
}  // namespace covis::exchange
