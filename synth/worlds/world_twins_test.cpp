// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "synth/render/renderer.h"
#include "synth/test_worlds.h"
#include "synth/worlds/world.h"

namespace covis {
namespace {

TEST(FoolingWorlds, TheTwinRoomsAreEqualAndThePassageIsNot) {
  const Camera& camera = world("twins").camera();
  synth::Renderer renderer = synth::Renderer::create(camera).value();
  for (const uint64_t seed : {1u, 2u}) {
    const synth::World twins = synth::make_twins(seed);
    const auto& polygons = twins.scene.polygons;
    // The first polygon is a wall of the first room; its texture comes once more, in the second.
    const auto twin = std::find_if(polygons.begin() + 1, polygons.end(),
                                   [&](const auto& p) { return p.texture == polygons[0].texture; });
    ASSERT_NE(twin, polygons.end());
    const Eigen::Vector3d spacing = twin->centre - polygons[0].centre;
    EXPECT_GT(spacing.x(), 9);
    EXPECT_NEAR(spacing.y(), 0, 1e-12);
    EXPECT_NEAR(spacing.z(), 0, 1e-12);
    // Two views of equal places: how often tone and depth are the same.
    const auto same = [&](const Eigen::Vector3d& position, double heading) {
      ImageF tone[2], depth[2];
      for (const int i : {0, 1}) {
        const synth::CameraPose pose{position + i * spacing, heading};
        renderer.render(twins.scene, pose.T_wc(), tone[i], depth[i]);
      }
      int equal = 0;
      for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
          equal += std::abs(tone[0](x, y) - tone[1](x, y)) < 1 && std::abs(depth[0](x, y) - depth[1](x, y)) < 1e-3f;
        }
      }
      return static_cast<double>(equal) / (camera.width * camera.height);
    };
    const Eigen::Vector3d inside(3, 2.8, 1.4);
    EXPECT_GT(same(inside, 1.6), 0.999) << "to one side, away from the openings";
    EXPECT_GT(same(inside, -1.6), 0.999) << "to the other";
    EXPECT_GT(same(inside, 0), 0.6) << "ahead, where the passages differ";
    EXPECT_LT(same(inside, 0), 0.999);
    EXPECT_LT(same(inside + 0.7 * spacing, 0), 0.2) << "from the passage and from behind all things";
    // Both are walked alike.
    const auto pose_at = [&](double x) {
      double seconds = 0;
      while (seconds < twins.path.period() && twins.path.at(seconds).position.x() < x) seconds += 0.01;
      return twins.path.at(seconds);
    };
    for (const double x : {1.0, 3.0, 5.0}) {
      const synth::CameraPose first = pose_at(x), second = pose_at(x + spacing.x());
      EXPECT_LT((first.position + spacing - second.position).norm(), 0.12) << x;
      EXPECT_NEAR(first.heading, second.heading, 0.12) << x;
      EXPECT_NEAR(first.pitch, second.pitch, 0.12) << x;
    }
  }
}

}  // namespace
}  // namespace covis
