// SPDX-License-Identifier: Apache-2.0
// A world: textured convex polygons in metres, z up, and helpers that build boxes, prisms and recessed openings.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "covis/core/random.h"
#include "synth/render/canvas.h"
#include "synth/render/texture.h"

namespace covis::synth {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The appearance of a face.
struct Skin {
  int texture = 0;
  double metres = 0;    // extent of the texture in the world, sideways and downwards; 0: stretched over the face
  double gain = 1;      // brightness
  double detail = 0.1;  // strength of the fine-grained detail visible close up
};

// A flat convex polygon. Texture coordinates are affine in the world: u = u_w . p + u_0.
struct Polygon {
  int first = 0, count = 0;  // in Scene::vertices
  Vector3d normal;           // points towards the visible side
  double offset = 0;         // normal . p = offset
  Vector3d u_w, v_w;
  double u_0 = 0, v_0 = 0;
  Vector3d centre;
  double radius = 0;
  int texture = 0;
  float gain = 1;
  float detail = 0;                  // relative amplitude
  float detail_u = 1, detail_v = 1;  // number of detail repeats per texture repeat
  bool two_sided = false;
  bool sky = false;     // depth is infinite
  bool window = false;  // indoors: daylight comes through it
  int light_map = -1;   // index in Scene::light_maps; -1: the light is as painted
};

// Light on a polygon: a texture that its tones are multiplied by, kLightAsPainted for 1. It is stretched over the
// polygon: its coordinates are u_scale * u + u_0 and v_scale * v + v_0.
struct LightMap {
  Texture texture;
  float u_scale, v_scale, u_0, v_0;
};

// A place on the floor: origin and heading of an object. Local x points to the object's front, y to its left, z up.
struct Place {
  Vector3d origin = Vector3d::Zero();
  double heading = 0;  // heading of local x about z, radians

  Vector3d operator()(double x, double y, double z) const;
  Vector3d turn(double x, double y, double z) const;
  Place at(double x, double y, double z, double turn = 0) const;
};

// A piece cut out of a scene, to be inserted at several places. Its textures stay in the scene.
struct Piece {
  std::vector<Polygon> polygons;
  std::vector<Vector3d> vertices;
};

class Scene {
 public:
  explicit Scene(uint64_t seed);

  int add_texture(const Canvas& canvas);

  // Adds a convex polygon, its corners in anticlockwise order as seen from its visible side. The texture's origin is at
  // `origin`; one whole texture extends by `right` to the right and by `down` downwards.
  Polygon& add_polygon(const std::vector<Vector3d>& corners, const Vector3d& origin, const Vector3d& right,
                       const Vector3d& down, const Skin& skin);
  // Adds a rectangle seen from the side where `right` points right and `down` down; `origin` is its top left corner.
  Polygon& add_rect(const Vector3d& origin, const Vector3d& right, const Vector3d& down, const Skin& skin);

  // Removes all polygons except the first `polygon_count` and returns them as a piece.
  Piece cut(size_t polygon_count);
  // Adds the piece as it was cut, with the world's origin and axes moved to `place`: same appearance, same shading.
  void put(const Piece& piece, const Place& place);

  std::vector<Polygon> polygons;
  std::vector<Vector3d> vertices;
  std::vector<Texture> textures;
  std::vector<LightMap> light_maps;
  Random random;                // random numbers for the builders
  double detail_metres = 0.45;  // extent of a whole detail texture (texture 0) on a surface
};

// Skins of a box's faces: front (+x), back (-x), left (+y), right (-y), top, bottom.
struct BoxSkin {
  Skin front, back, left, right, top, bottom;
  explicit BoxSkin(const Skin& all) : front(all), back(all), left(all), right(all), top(all), bottom(all) {}
  BoxSkin(const Skin& front_skin, const Skin& others) : BoxSkin(others) { front = front_skin; }
};

// closed: with a face below, for a box that does not stand on the floor.
enum class Bottom { open, closed };
// Adds a box whose bottom centre is at `place`, `depth` along its x, `width` along y. Faces are slightly shaded by
// direction.
void add_box(Scene& scene, const Place& place, double depth, double width, double height, const BoxSkin& skin,
             Bottom bottom = Bottom::open);
// Adds an upright prism of `sides` faces with a lid; its radius goes from r0 at the bottom to r1 at the top.
void add_prism(Scene& scene, const Place& place, double r0, double r1, double height, int sides, const Skin& side,
               const Skin& lid);
// Light on a surface with the given normal: 1 for a wall of medium brightness.
double light(const Vector3d& normal);

}  // namespace covis::synth
