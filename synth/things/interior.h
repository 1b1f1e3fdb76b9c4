// SPDX-License-Identifier: Apache-2.0
// Walls and floors of indoor worlds, and the objects that stand or hang along a wall.
#pragma once

#include <string>
#include <vector>

#include "synth/render/scene.h"

namespace covis::synth {

// An upright wall from `left` to `right`, as seen by someone standing in front of it.
struct Wall {
  Vector2d left, right;
  double height;

  double length() const { return (right - left).norm(); }
  // Returns the place on the floor at the wall, `along` metres from its left end, facing away from the wall; local y
  // points right.
  Place at(double along) const;
};

// A horizontal floor rectangle with its own painting, on which shadows are drawn before it joins the scene.
struct Floor {
  Vector2d low;
  Canvas canvas;  // right along +y, down along +x
};

// Adds a soft shadow below an object with this depth (along the place's x) and width, placed against a wall.
void add_shadow(std::vector<Floor>& floors, const Place& place, double depth, double width);
void add_floor(Scene& scene, Floor floor, double detail);

Canvas floor_canvas(Random& random, double width, double length);
// Adds the wall's surface: bricks, plaster, wallpaper or panels.
void add_wall_surface(Scene& scene, const Wall& wall);

void add_window(Scene& scene, const Place& wall, double width, double height, double sill);
void add_door(Scene& scene, const Place& wall);
// Adds a picture, poster, notice board or clock between `bottom` and `top`, at most `width` wide.
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

// Fills the wall from left to right between the two margins with objects of the given kinds, no kind twice in a row.
void furnish(Scene& scene, const Wall& wall, std::vector<Floor>& floors, const std::vector<Kind>& kinds,
             double margin_left, double margin_right);

}  // namespace covis::synth
