// SPDX-License-Identifier: Apache-2.0
// Furniture for the worlds. Each object is built at a place: its back middle on the floor, its front towards the
// place's local x.
#pragma once

#include "synth/render/scene.h"

namespace covis::synth {

// Make the skin of a canvas stretched over a face, and of a material at its own scale.
Skin painted(Scene& scene, const Canvas& canvas, double detail = 0.06);
Skin material(Scene& scene, const Canvas& canvas, double detail = 0.1);

// Objects that stand against a wall.
void add_bookcase(Scene& scene, const Place& place, double width, double height);
void add_desk(Scene& scene, const Place& place, double width);
void add_cabinet(Scene& scene, const Place& place, double width, double height, double depth);
void add_sofa(Scene& scene, const Place& place, double width);
void add_boxes(Scene& scene, const Place& place);  // a stack of cardboard boxes
void add_radiator(Scene& scene, const Place& place, double width);
void add_plant(Scene& scene, const Place& place, double height);
void add_floor_lamp(Scene& scene, const Place& place);
// Free-standing objects: the place is their middle.
void add_table(Scene& scene, const Place& place, double depth, double width, double height, const Skin& wood);
void add_chair(Scene& scene, const Place& place, const Skin& wood);

// Objects on a wall: the place's origin is the object's middle, on the wall.
void add_picture(Scene& scene, const Place& place, double width, double height, const Canvas& picture,
                 double thickness = 0.025);
void add_clock(Scene& scene, const Place& place, double size);

// Adds a crown of leaf polygons around `centre`.
void add_foliage(Scene& scene, const Vector3d& centre, double radius, double leaf, int count, int texture);

}  // namespace covis::synth
