// SPDX-License-Identifier: Apache-2.0
#include "synth/render/lighting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "synth/render/renderer.h"

namespace covis::synth {
namespace {

CameraPath path_above_ground() {
  std::vector<CameraPose> control(8, CameraPose{{0, 0, 3}, 0, -1.2});
  for (size_t i = 0; i < control.size(); ++i) control[i].position.x() = 0.5 * static_cast<double>(i) - 2;
  return {control, 1, {}, 1};
}

// A ground of 20 m x 20 m with a box of 1 m on it.
Scene ground_with_box() {
  Scene scene(1);
  const Skin skin{.texture = scene.add_texture(Canvas(1, 1, 20, 100)), .detail = 0};
  scene.add_rect({-10, -10, 0}, {0, 20, 0}, {20, 0, 0}, skin);
  add_box(scene, {{0, 0, 0}, 0}, 1, 1, 1, BoxSkin(skin));
  return scene;
}

// Tones of the ground as seen from above.
std::vector<float> ground_tones(const Scene& scene) {
  Camera camera;
  camera.width = camera.height = 200;
  camera.pinhole = {200, 200, 99.5, 99.5, 0};
  Renderer renderer = Renderer::create(camera).value();
  ImageF tone, depth;
  renderer.render(scene, CameraPose{{0, 0, 10}, 0, -1.5707963}.T_wc(), tone, depth);
  std::vector<float> tones;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      if (depth(x, y) > 9.9f) tones.push_back(tone(x, y));
    }
  }
  return tones;
}

TEST(Lighting, ABoxInTheSunThrowsAShadow) {
  Scene scene = ground_with_box();
  Polygon& sky = scene.add_rect({50, -50, 50}, {0, 100, 0}, {-100, 0, 0}, {});
  sky.sky = true;
  const size_t last = scene.polygons.size() - 1;
  relight(scene, path_above_ground(), 7);
  EXPECT_EQ(scene.polygons[last].light_map, -1) << "the sky shines by itself";
  EXPECT_EQ(scene.light_maps.size(), last);
  std::vector<float> tones = ground_tones(scene);
  std::sort(tones.begin(), tones.end());
  const float sunny = tones[tones.size() / 2], shadow = tones[tones.size() / 500];
  EXPECT_LT(shadow, 0.7f * sunny);
  EXPECT_NEAR(tones[tones.size() / 4], sunny, 1) << "most of the ground is lit alike";
}

TEST(Lighting, LampsShineLessFarAway) {
  Scene scene = ground_with_box();
  relight(scene, path_above_ground(), 3);
  std::vector<float> tones = ground_tones(scene);
  std::sort(tones.begin(), tones.end());
  const auto share = [&](double q) { return tones[static_cast<size_t>(q * static_cast<double>(tones.size() - 1))]; };
  EXPECT_GT(share(0.98), 1.15f * share(0.02));
}

TEST(Lighting, WindowsShineByThemselves) {
  Scene scene = ground_with_box();
  const Skin skin{.texture = 1, .detail = 0};
  scene.add_rect({9, 1, 3}, {0, -2, 0}, {0, 0, -2}, skin).window = true;
  relight(scene, path_above_ground(), 5);
  EXPECT_EQ(scene.polygons.back().light_map, -1);
  EXPECT_EQ(scene.polygons.front().light_map, 0);
}

}  // namespace
}  // namespace covis::synth
