// SPDX-License-Identifier: Apache-2.0
// For the tests of things: how much of the world a scene's polygons fill, and whether they are sound.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <numeric>

#include "synth/render/scene.h"

namespace covis::synth {

inline Eigen::AlignedBox3d extent(const Scene& scene) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& v : scene.vertices) box.extend(v);
  return box;
}

// Flat, with outward normals of length one, textures that are there, and corners in order.
inline void expect_sound(const Scene& scene) {
  EXPECT_FALSE(scene.polygons.empty());
  for (const Polygon& p : scene.polygons) {
    ASSERT_GE(p.count, 3);
    ASSERT_LT(static_cast<size_t>(p.texture), scene.textures.size());
    ASSERT_NEAR(p.normal.norm(), 1, 1e-9);
    for (int i = 0; i < p.count; ++i) {
      const auto corner = [&](int k) -> const Vector3d& {
        return scene.vertices[static_cast<size_t>(p.first + k % p.count)];
      };
      ASSERT_NEAR(p.normal.dot(corner(i)), p.offset, 1e-6);
      ASSERT_LE((corner(i) - p.centre).norm(), p.radius + 1e-6);
      if (p.two_sided) continue;  // leaves: neither convex nor in one order
      // Convex: every turn is to the same side.
      ASSERT_GT((corner(i + 1) - corner(i)).cross(corner(i + 2) - corner(i + 1)).dot(p.normal), -1e-9);
    }
  }
}

// A number for a canvas that differs when a pixel does.
inline double sum_of(const Canvas& canvas) {
  double sum = 0;
  for (size_t i = 0; i < canvas.pixels().size(); ++i)
    sum += static_cast<double>(canvas.pixels()[i]) * static_cast<double>(1 + i % 97);
  return sum;
}

}  // namespace covis::synth
