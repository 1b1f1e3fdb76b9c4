// SPDX-License-Identifier: Apache-2.0
// The worlds made to fool: what looks alike there is equal, and is not the same place.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "synth/render/renderer.h"
#include "synth/render/scene.h"
#include "synth/test_worlds.h"
#include "synth/worlds/world.h"

namespace covis {
namespace {

TEST(FoolingWorlds, OpenPathsEndAtRestInsideTheirWorld) {
  for (const char* name : {"twins", "posters"}) {
    SynthOptions options = small(name);
    Synth& plain = world(name);
    options.frames = 2 * plain.frames();
    Synth longer = make(options);
    EXPECT_LT((longer.T_wc(2 * plain.frames() - 1).t() - longer.T_wc(plain.frames()).t()).norm(), 0.5) << name;
    ImageU8 image;
    ImageF depth;
    longer.render(2 * plain.frames() - 1, image, nullptr, &depth);
    for (int y = 0; y < depth.height(); ++y) {
      ASSERT_GT(*std::min_element(depth.row(y), depth.row(y) + depth.width()), 0.15f) << name;
    }
  }
}

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

TEST(FoolingWorlds, TheHallRepeatsItsPostersInOtherPlaces) {
  for (const uint64_t seed : {1u, 2u}) {
    const synth::World hall = synth::make_posters(seed);
    std::map<int, std::vector<Eigen::Vector3d>> places;
    for (const auto& p : hall.scene.polygons) {
      if (std::abs(p.normal.z()) < 0.1 && p.centre.z() > 0.9 && p.centre.z() < 1.8) {
        places[p.texture].push_back(p.centre);
      }
    }
    int repeated = 0;
    for (const auto& [texture, centres] : places) repeated += centres.size() >= 4;
    EXPECT_GE(repeated, 6) << "three posters, two doors and a board";
  }
}

TEST(Scene, APiecePutElsewhereLooksTheSame) {
  const auto make_scene = [] {
    synth::Scene scene(5);
    synth::Canvas canvas(1, 1, 100, 120);
    canvas.fractal(0.3, 60, 4, 0.8, 3);
    synth::Skin skin{.texture = scene.add_texture(canvas), .metres = 1, .detail = 0.1};
    synth::add_box(scene, {{3, 0.2, 0}, 0.3}, 0.5, 0.7, 0.9, synth::BoxSkin(skin));
    return scene;
  };
  const synth::Scene plain = make_scene();
  synth::Scene moved = make_scene();
  const synth::Piece piece = moved.cut(2);
  EXPECT_EQ(moved.polygons.size(), 2u);
  EXPECT_EQ(piece.polygons.size() + 2, plain.polygons.size());
  const synth::Place place{{4, -3, 0.5}, 1.1};
  moved.put(piece, place);
  ASSERT_EQ(moved.polygons.size(), plain.polygons.size());
  for (size_t k = 2; k < plain.polygons.size(); ++k) {
    const synth::Polygon &p = plain.polygons[k], &q = moved.polygons[k];
    ASSERT_EQ(p.count, q.count);
    EXPECT_EQ(p.gain, q.gain);
    EXPECT_EQ(p.radius, q.radius);
    for (int i = 0; i < p.count; ++i) {
      const Eigen::Vector3d& a = plain.vertices[static_cast<size_t>(p.first + i)];
      const Eigen::Vector3d& b = moved.vertices[static_cast<size_t>(q.first + i)];
      EXPECT_TRUE(b.isApprox(place(a.x(), a.y(), a.z()), 1e-12));
      EXPECT_NEAR(q.normal.dot(b), q.offset, 1e-12);
      EXPECT_NEAR(p.u_w.dot(a) + p.u_0, q.u_w.dot(b) + q.u_0, 1e-12);
      EXPECT_NEAR(p.v_w.dot(a) + p.v_0, q.v_w.dot(b) + q.v_0, 1e-12);
    }
    EXPECT_TRUE(q.centre.isApprox(place(p.centre.x(), p.centre.y(), p.centre.z()), 1e-12));
  }
}

}  // namespace
}  // namespace covis
