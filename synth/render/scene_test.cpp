// SPDX-License-Identifier: Apache-2.0
#include "synth/render/scene.h"

#include <gtest/gtest.h>

namespace covis {
namespace {

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

TEST(Scene, ABoxIsClosedAndItsFacesLookOutward) {
  synth::Scene scene(5);
  const synth::Skin skin{.texture = scene.add_texture(synth::Canvas(1, 1, 20, 120))};
  synth::add_box(scene, {{1, 2, 3}, 0}, 0.5, 0.7, 0.9, synth::BoxSkin(skin), synth::Bottom::closed);
  ASSERT_EQ(scene.polygons.size(), 6u);
  const Eigen::Vector3d middle(1, 2, 3.45);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const synth::Polygon& p : scene.polygons) {
    EXPECT_GT(p.normal.dot(p.centre - middle), 0);
    sum += p.normal;
    for (int i = 0; i < p.count; ++i) {
      const Eigen::Vector3d from_middle = scene.vertices[static_cast<size_t>(p.first + i)] - middle;
      EXPECT_TRUE(from_middle.cwiseAbs().isApprox(Eigen::Vector3d(0.25, 0.35, 0.45), 1e-12));
    }
  }
  EXPECT_LT(sum.norm(), 1e-12);
}

TEST(Scene, PlacesAreRelativeToEachOther) {
  const synth::Place place{{1, 2, 0}, 0.5};
  const synth::Place inner = place.at(3, 4, 5, 0.25);
  EXPECT_TRUE(inner.origin.isApprox(place(3, 4, 5)));
  EXPECT_DOUBLE_EQ(inner.heading, 0.75);
  EXPECT_NEAR(place.turn(3, 4, 0).norm(), 5, 1e-12);
}

}  // namespace
}  // namespace covis
