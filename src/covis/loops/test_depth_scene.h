// SPDX-License-Identifier: Apache-2.0
// For tests: a wavy wall of bare points, and the images of a depth camera that is not registered to the one that sees
// them.
#pragma once

#include <cmath>
#include <memory>

#include "covis/features/kept_depth.h"
#include "covis/map/test_point_scene.h"

namespace covis {

struct DepthScene {
  static constexpr int kWidth = 320, kHeight = 240;

  PointScene scene;
  DepthRegistration registration;  // the depth camera's images have this one

  explicit DepthScene(const DepthRegistration& r, size_t steps = 16) : registration(r) {
    scene.camera = {250, 250, 160, 120, 20};
    scene.camera.depth_noise = DepthNoise::kinect();
    scene.bounds = {0, 0, kWidth, kHeight};
    Random random(1);
    const double end = kStep * static_cast<double>(steps);
    for (int p = 0; p < 900; ++p) {
      const double x = random.uniform(-3, 3 + end), y = random.uniform(-2.5, 2.5);
      scene.add_point({x, y, wall(x, y)}, 12, random);
    }
    for (size_t i = 0; i < steps; ++i) {
      const auto k = static_cast<double>(i);
      scene.T_wc.emplace_back(Eigen::Matrix3d::Identity(), Eigen::Vector3d(kStep * k, 0.2 * std::sin(k), 0.02 * k));
    }
  }

  // The depth camera's image from the i-th pose; only the pixels that are kept have a depth.
  std::shared_ptr<const KeptDepth> depth(size_t i) const {
    const Pinhole& camera = scene.camera;
    const Eigen::Vector3d at = scene.T_wc_of(i).t();
    const Eigen::Vector2d centre(camera.cx, camera.cy);
    ImageF image(kWidth, kHeight);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        image(u, v) = 0;
        if (u % 2 != 0 || v % 2 != 0) continue;
        double z = 4;
        for (int k = 0; k < 12; ++k) {  // the pixel of the image that shows the same, and the wall there
          const Eigen::Vector2d moved = Eigen::Vector2d(u, v) -
                                        Eigen::Vector2d(registration.shift_x, registration.shift_y) -
                                        Eigen::Vector2d(registration.parallax_x, registration.parallax_y) / z;
          const Eigen::Vector2d pixel = centre + (moved - centre) / registration.scale;
          const Eigen::Vector3d ray = camera.unproject(pixel.x(), pixel.y());
          z = wall(at.x() + z * ray.x(), at.y() + z * ray.y()) - at.z();
        }
        image(u, v) = static_cast<float>(z);
      }
    }
    return std::make_shared<const KeptDepth>(image.view());
  }

 private:
  static constexpr double kStep = 0.25;  // metres
  static double wall(double x, double y) { return 4 + 0.8 * std::sin(1.6 * x) + 0.6 * std::sin(1.9 * y + x); }
};

}  // namespace covis
