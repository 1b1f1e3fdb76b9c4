// SPDX-License-Identifier: Apache-2.0
#include "synth/render/renderer.h"

#include <gtest/gtest.h>

#include "synth/render/camera_path.h"

namespace covis::synth {
namespace {

// A wall of one tone at x = 3, 4 m wide and high, and a smaller one of another tone before it.
Scene two_walls() {
  Scene scene(1);
  const auto skin = [&](double tone) {
    return Skin{.texture = scene.add_texture(Canvas(1, 1, 20, tone)), .detail = 0};
  };
  scene.add_rect({3, 2, 2}, {0, -4, 0}, {0, 0, -4}, skin(80));
  scene.add_rect({2, 0.5, 0.5}, {0, -1, 0}, {0, 0, -1}, skin(160));
  return scene;
}

Camera small_camera() {
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.pinhole = {40, 40, 31.5, 23.5, 0};
  return camera;
}

TEST(Renderer, DepthIsThatOfTheNearestPlane) {
  Renderer renderer = Renderer::create(small_camera()).value();
  ImageF tone, depth;
  const Scene scene = two_walls();
  renderer.render(scene, CameraPose{}.T_wc(), tone, depth);
  EXPECT_NEAR(depth(32, 24), 2, 1e-5);
  EXPECT_NEAR(tone(32, 24), 160, 1);
  EXPECT_NEAR(depth(50, 24), 3, 1e-5);
  EXPECT_NEAR(tone(50, 24), 80, 1);
  EXPECT_EQ(depth(0, 0), 0) << "beside the walls there is nothing";
  // The inner wall covers 1 m at 2 m: 20 x 20 pixels, its edges between two.
  int near = 0;
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) near += depth(x, y) > 0 && depth(x, y) < 2.5f;
  }
  EXPECT_EQ(near, 400);
}

TEST(Renderer, WallsAreSeenFromTheirFrontAlone) {
  Renderer renderer = Renderer::create(small_camera()).value();
  ImageF tone, depth;
  const CameraPose behind{{6, 0, 0}, 3.14159265};
  renderer.render(two_walls(), behind.T_wc(), tone, depth);
  EXPECT_EQ(depth(32, 24), 0);
}

TEST(Renderer, RefusesALensThatCanNotBeInverted) {
  Camera camera = small_camera();
  camera.distortion = Distortion::brown_conrady;
  camera.coefficients = {-3, 0, 0, 0, 0};
  EXPECT_FALSE(Renderer::create(camera));
}

}  // namespace
}  // namespace covis::synth
