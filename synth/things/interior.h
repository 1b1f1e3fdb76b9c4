// SPDX-License-Identifier: Apache-2.0
// Walls and floors of indoor worlds, and what stands and hangs along a wall.
#pragma once

#include <string>
#include <vector>

#include "synth/render/scene.h"

namespace covis::synth {

// An upright wall from `left` to `right`, as one sees them who stands in front of it.
struct Wall {
  Vector2d left, right;
  double height;

  double length() const { return (right - left).norm(); }
  // On the floor at the wall, `along` metres from its left end, facing away from the wall; local y points right.
  Place at(double along) const;
};

// A level rectangle of floor with its own painting, on which shadows of furniture are drawn before it joins the scene.
struct Floor {
  Vector2d low;
  Canvas canvas;  // right along +y, down along +x
};

// A soft shadow below a thing of depth (along the place's x) and width at a place against a wall.
void add_shadow(std::vector<Floor>& floors, const Place& place, double depth, double width);
void add_floor(Scene& scene, Floor floor, double detail);

Canvas floor_canvas(Random& random, double width, double length);
// The wall's surface: bricks, plaster, wallpaper or panels.
void add_wall_surface(Scene& scene, const Wall& wall);

void add_window(Scene& scene, const Place& wall, double width, double height, double sill);
void add_door(Scene& scene, const Place& wall);
// A picture, poster, notice board or clock in the space from `bottom` to `top`, at most `width` wide.
void add_wall_piece(Scene& scene, const Place& wall, double bottom, double top, double width);

enum class Kind {
  bookcase,
  desk,
  cabinet,
  sofa,
  boxes,
  window,
  greenery,
  door,
  pictures,
  pillar,
  bench,
  machine,
  lockers
};

// Fills the wall from left to right between the two margins with things of the given kinds, no kind twice in a row.
void furnish(Scene& scene, const Wall& wall, std::vector<Floor>& floors, const std::vector<Kind>& kinds,
             double margin_left, double margin_right);

}  // namespace covis::synth
