// SPDX-License-Identifier: Apache-2.0
// For tests: a scene of bare points, seen from a ring of key frames.
#pragma once

#include <gmock/gmock.h>

#include "covis/core/test_folder.h"
#include "covis/exchange/scene.h"
#include "covis/map/test_point_scene.h"

namespace covis::exchange {

inline std::vector<Scene> ring_scenes() {
  PointScene scene = PointScene::ring(600, 24);
  scene.camera = {500, 480, 300, 250, 50};
  SceneMap world(scene, Sensor::rgbd);
  world.add_key_frames(8);
  world.begin_submap();
  world.add_key_frames(3, 12);
  for (const KeyFrameId& id : world.frames) {
    const size_t count = world.shared.read()->at(id).points.size();
    world.shared.write()->set_colours(id, std::make_shared<const std::vector<Colour>>(count, Colour{200, 100, 50}));
  }
  return scenes_of(*world.shared.read(), {640, 480, scene.camera, Distortion::none, {}});
}

}  // namespace covis::exchange
