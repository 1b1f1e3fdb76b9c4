// SPDX-License-Identifier: Apache-2.0
// Buildings, cars, trees and street furniture. A building's place is the middle of its front on the ground, facing the
// street; other objects stand on their place.
#pragma once

#include "synth/render/scene.h"

namespace covis::synth {

void add_building(Scene& scene, const Place& place, double width, double depth);
void add_garden(Scene& scene, const Place& place, double width, double depth,
                int leaf_texture);  // a gap between houses
void add_car(Scene& scene, const Place& place);
void add_tree(Scene& scene, const Place& place, int leaf_texture);
void add_street_furniture(Scene& scene, const Place& place);  // a lamp post, bin, sign, letter box or kiosk

}  // namespace covis::synth
