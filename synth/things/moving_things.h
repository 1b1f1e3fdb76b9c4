// SPDX-License-Identifier: Apache-2.0
// Things that move while the camera does: people who walk before it or towards it, cars on its street, a book that
// somebody moves over the desk. Each is rigid; where it is follows from the time, the camera's path and a seed.
#pragma once

#include <cstdint>
#include <vector>

#include "synth/render/camera_path.h"
#include "synth/render/scene.h"

namespace covis::synth {

enum class Traffic {
  people_around,  // people 1 to 2 m from the camera who walk to and fro before it
  people_along,   // people who walk before the camera on its way; every second one comes towards it
  cars,           // cars that drive before the camera; every second one comes towards it in the other lane
  hands,          // books that are moved between the camera and the desk, at half its distance
};

class MovingThings {
 public:
  // Adds the textures of `count` things to the scene.
  MovingThings(Scene& scene, Traffic traffic, int count, uint64_t seed);

  // Moves the things to where they are at a time, beside a camera that goes along `path`.
  void place(const CameraPath& path, double seconds, Scene& scene) const;

 private:
  struct Thing {
    Piece piece;
    bool oncoming;
    double distance, aside;          // from the camera: metres, but seconds ahead for what goes along its way
    double swing, frequency, phase;  // to and fro: amplitude in radians or metres, Hz, radians
  };

  Vector3d spot(const Thing& thing, const CameraPath& path, double seconds) const;

  Traffic traffic_;
  std::vector<Thing> things_;
  size_t polygons_, vertices_;  // sizes of the scene without the things
};

}  // namespace covis::synth
