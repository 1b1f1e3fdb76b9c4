// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "synth/worlds/world.h"

namespace covis {
namespace {

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

}  // namespace
}  // namespace covis
