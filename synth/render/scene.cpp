// SPDX-License-Identifier: Apache-2.0
#include "synth/render/scene.h"

#include <Eigen/Geometry>
#include <cassert>

namespace covis::synth {
namespace {

// Texture 0: grain and scratches around middle grey. The renderer overlays it on every surface at its own fine scale,
// so that surfaces seen close up are not blank between the texels of their own texture.
Canvas detail_canvas(uint64_t seed) {
  Canvas canvas(1, 1, 512, 128);
  canvas.fractal(0.12, 40, 6, 0.8, hash_seed(seed, 1));
  canvas.spots(500, 0.003, 0.012, 40, 0.6, hash_seed(seed, 2));
  canvas.spots(500, 0.002, 0.010, 225, 0.6, hash_seed(seed, 3));
  Random random(hash_seed(seed, 4));
  for (int i = 0; i < 60; ++i) {
    const double x = random.uniform(), y = random.uniform(), a = random.uniform(0, 6.283),
                 l = random.uniform(0.02, 0.12);
    canvas.line(x, y, x + l * std::cos(a), y + l * std::sin(a), 0.004, random.below(2) ? 60 : 200, 0.5);
  }
  return canvas;
}

}  // namespace

Scene::Scene(uint64_t seed) : random(seed) { add_texture(detail_canvas(hash_seed(seed, 77))); }

int Scene::add_texture(const Canvas& canvas) {
  textures.emplace_back(canvas);
  return static_cast<int>(textures.size()) - 1;
}

Polygon& Scene::add_polygon(const std::vector<Vector3d>& corners, const Vector3d& origin, const Vector3d& right,
                            const Vector3d& down, const Skin& skin) {
  assert(corners.size() >= 3);
  Polygon p;
  p.first = static_cast<int>(vertices.size());
  p.count = static_cast<int>(corners.size());
  vertices.insert(vertices.end(), corners.begin(), corners.end());
  p.normal = down.cross(right).normalized();
  p.offset = p.normal.dot(corners[0]);
  // Uses the dual basis, so that right and down need not be perpendicular.
  const Vector3d n = right.cross(down);
  p.u_w = down.cross(n) / n.squaredNorm();
  p.v_w = n.cross(right) / n.squaredNorm();
  p.u_0 = -p.u_w.dot(origin);
  p.v_0 = -p.v_w.dot(origin);
  p.centre.setZero();
  for (const Vector3d& corner : corners) p.centre += corner / static_cast<double>(corners.size());
  for (const Vector3d& corner : corners) p.radius = std::max(p.radius, (corner - p.centre).norm());
  p.texture = skin.texture;
  p.gain = static_cast<float>(skin.gain);
  p.detail = static_cast<float>(skin.detail);
  p.detail_u = static_cast<float>(right.norm() / detail_metres);
  p.detail_v = static_cast<float>(down.norm() / detail_metres);
  polygons.push_back(p);
  return polygons.back();
}

Polygon& Scene::add_rect(const Vector3d& origin, const Vector3d& right, const Vector3d& down, const Skin& skin) {
  const std::vector<Vector3d> corners{origin, origin + down, origin + down + right, origin + right};
  if (skin.metres <= 0) return add_polygon(corners, origin, right, down, skin);
  // Takes the piece of material from its own position, so that two faces do not look the same.
  const Vector3d r = right.normalized() * skin.metres, d = down.normalized() * skin.metres;
  const double du = random.uniform(), dv = random.uniform();
  return add_polygon(corners, origin - du * r - dv * d, r, d, skin);
}

Piece Scene::cut(size_t polygon_count) {
  assert(polygon_count <= polygons.size());
  Piece piece;
  const auto begin = polygons.begin() + static_cast<ptrdiff_t>(polygon_count);
  if (begin == polygons.end()) return piece;
  // Polygons and vertices are added in the same order.
  const int first = begin->first;
  piece.polygons.assign(begin, polygons.end());
  piece.vertices.assign(vertices.begin() + first, vertices.end());
  for (Polygon& p : piece.polygons) p.first -= first;
  polygons.erase(begin, polygons.end());
  vertices.resize(static_cast<size_t>(first));
  return piece;
}

void Scene::put(const Piece& piece, const Place& place) {
  const int first = static_cast<int>(vertices.size());
  const auto moved = [&](const Vector3d& v) { return place(v.x(), v.y(), v.z()); };
  const auto turned = [&](const Vector3d& v) { return place.turn(v.x(), v.y(), v.z()); };
  for (const Vector3d& v : piece.vertices) vertices.push_back(moved(v));
  for (Polygon p : piece.polygons) {
    p.first += first;
    p.normal = turned(p.normal);
    p.offset += p.normal.dot(place.origin);
    p.u_w = turned(p.u_w);
    p.v_w = turned(p.v_w);
    p.u_0 -= p.u_w.dot(place.origin);
    p.v_0 -= p.v_w.dot(place.origin);
    p.centre = moved(p.centre);
    polygons.push_back(p);
  }
}

Vector3d Place::turn(double x, double y, double z) const {
  const double c = std::cos(heading), s = std::sin(heading);
  return {c * x - s * y, s * x + c * y, z};
}

Vector3d Place::operator()(double x, double y, double z) const { return origin + turn(x, y, z); }

Place Place::at(double x, double y, double z, double more) const { return {(*this)(x, y, z), heading + more}; }

double light(const Vector3d& normal) {
  // Light from the sky above and a weak sun from the side: enough to distinguish the faces of a box.
  return 0.86 + 0.16 * normal.z() + 0.14 * normal.dot(Vector3d(0.55, -0.83, 0.0));
}

void add_box(Scene& scene, const Place& place, double depth, double width, double height, const BoxSkin& skin,
             Bottom bottom) {
  const double x = 0.5 * depth, y = 0.5 * width, h = height;
  const auto face = [&](const Vector3d& origin, const Vector3d& right, const Vector3d& down, Skin s) {
    s.gain *= light(down.cross(right).normalized());
    scene.add_rect(origin, right, down, s);
  };
  const Vector3d down(0, 0, -h);
  face(place(x, -y, h), place.turn(0, width, 0), down, skin.front);
  face(place(-x, y, h), place.turn(0, -width, 0), down, skin.back);
  face(place(x, y, h), place.turn(-depth, 0, 0), down, skin.left);
  face(place(-x, -y, h), place.turn(depth, 0, 0), down, skin.right);
  face(place(-x, -y, h), place.turn(0, width, 0), place.turn(depth, 0, 0), skin.top);
  if (bottom == Bottom::closed) face(place(x, -y, 0), place.turn(0, width, 0), place.turn(-depth, 0, 0), skin.bottom);
}

void add_prism(Scene& scene, const Place& place, double r0, double r1, double height, int sides, const Skin& side,
               const Skin& lid) {
  std::vector<Vector3d> low, high;
  for (int i = 0; i < sides; ++i) {
    const double a = 6.283185307179586 * i / sides;
    low.push_back(place(r0 * std::cos(a), r0 * std::sin(a), 0));
    high.push_back(place(r1 * std::cos(a), r1 * std::sin(a), height));
  }
  for (size_t i = 0; i < low.size(); ++i) {
    const size_t k = (i + 1) % low.size();
    // Seen from outside, the next corner (anticlockwise from above) lies to the right.
    const Vector3d right = 0.5 * (low[k] - low[i] + high[k] - high[i]);
    const Vector3d down = 0.5 * (low[i] - high[i] + low[k] - high[k]);
    Skin s = side;
    s.gain *= light(down.cross(right).normalized());
    const double t = static_cast<double>(i);
    const double n = static_cast<double>(sides);
    // The texture goes once around the prism.
    scene.add_polygon({high[i], low[i], low[k], high[k]}, 0.5 * (high[i] + high[k]) - right * (t + 0.5), right * n,
                      down, s);
  }
  Skin top = lid;
  top.gain *= light(Vector3d::UnitZ());
  const double r = std::max(r0, r1);
  scene.add_polygon(high, place(-r, -r, height), place.turn(0, 2 * r, 0), place.turn(2 * r, 0, 0), top);
}

}  // namespace covis::synth
