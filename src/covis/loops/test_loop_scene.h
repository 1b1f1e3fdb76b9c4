// SPDX-License-Identifier: Apache-2.0
// For the tests of loops: once around a ring of points, with a drift that grows all the way, until the camera is back
// where it began; there it takes the points it sees for new ones. Or the same in two submaps.
#pragma once

#include "covis/map/test_point_scene.h"

namespace covis {

struct LoopScene {
  static constexpr size_t kSteps = 48;  // steps of the ring

  const PointScene scene = PointScene::ring(2400, kSteps);
  SceneMap world;
  Vector6d drift = (Vector6d() << 0.15, 0.08, 0.05, 0, 0.03, 0).finished();  // the camera's, after the whole way
  KeyFrameId current;                                                        // the last key frame

  explicit LoopScene(Sensor sensor = Sensor::rgbd) : world(scene, sensor) { world.memory = 8; }

  // Once around and so many steps more. The first key frame is the world.
  void go_around(size_t more = 4) {
    for (size_t i = 0; i < kSteps + more; ++i) {
      const Vector6d xi = drift * (static_cast<double>(i) / kSteps);
      current = world.add(scene.T_cw(i), SE3::exp(xi) * scene.T_cw(i));
    }
  }
  // `count` key frames, and as many of a submap of its own, which sees the same from `shift` on.
  void go_twice(size_t count, const SE3& shift) {
    world.add_key_frames(count);
    world.begin_submap();
    for (size_t i = 0; i < count; ++i) current = world.add(scene.T_cw(i), scene.T_cw(i) * shift);
  }
  // The first key frame that the camera is nearest to when it is back.
  KeyFrameId place() const { return world.frames[(world.frames.size() - 1) % kSteps]; }
};

}  // namespace covis
