// SPDX-License-Identifier: Apache-2.0
#include "synth/render/occlusion.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace covis::synth {
namespace {

constexpr int kLeaf = 4;    // most polygons of a leaf
constexpr int kDepth = 64;  // more levels than a tree with halved leaves can have

// True when the ray meets the box before `reach`. `inverse`: 1 / direction, infinite where that is 0.
template <class Box>
bool meets(const Box& box, const Vector3d& from, const Vector3d& inverse, double reach) {
  double enter = 0, leave = reach;
  for (int k = 0; k < 3; ++k) {
    const double a = (box.low[k] - from[k]) * inverse[k], b = (box.high[k] - from[k]) * inverse[k];
    enter = std::max(enter, std::min(a, b));  // a NaN (0 times infinity) leaves the interval as it is
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

}  // namespace

Occlusion::Occlusion(const Scene& scene) : scene_(scene) {
  constexpr double kMargin = 1e-6;  // metres, so that flat boxes are met
  std::vector<Box> boxes;
  for (const Polygon& polygon : scene.polygons) {
    Box& box = boxes.emplace_back(Box{Vector3d::Constant(1e30), Vector3d::Constant(-1e30)});
    for (int i = 0; i < polygon.count; ++i) {
      const Vector3d& corner = scene.vertices[static_cast<size_t>(polygon.first + i)];
      box.low = box.low.cwiseMin((corner.array() - kMargin).matrix());
      box.high = box.high.cwiseMax((corner.array() + kMargin).matrix());
    }
    if (!polygon.sky) order_.push_back(static_cast<int>(boxes.size()) - 1);
  }
  if (!order_.empty()) build(boxes, 0, static_cast<int>(order_.size()));
}

void Occlusion::build(const std::vector<Box>& boxes, int begin, int end) {
  const size_t at = nodes_.size();
  Box box = boxes[static_cast<size_t>(order_[static_cast<size_t>(begin)])];
  for (int i = begin; i < end; ++i) {
    const Box& other = boxes[static_cast<size_t>(order_[static_cast<size_t>(i)])];
    box.low = box.low.cwiseMin(other.low);
    box.high = box.high.cwiseMax(other.high);
  }
  nodes_.push_back({box, begin, end - begin});
  if (end - begin <= kLeaf) return;
  Eigen::Index axis = 0;
  (box.high - box.low).maxCoeff(&axis);
  const int middle = begin + (end - begin) / 2;
  const auto key = [&](int polygon) {
    const Box& b = boxes[static_cast<size_t>(polygon)];
    return std::pair(b.low[axis] + b.high[axis], polygon);
  };
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](int a, int b) { return key(a) < key(b); });
  build(boxes, begin, middle);
  nodes_[at].first = static_cast<int>(nodes_.size());
  nodes_[at].count = 0;
  build(boxes, middle, end);
}

template <class Visit>
void Occlusion::walk(const Vector3d& from, const Vector3d& direction, const double& reach, Visit&& visit) const {
  if (nodes_.empty()) return;
  const Vector3d inverse = direction.cwiseInverse();
  std::array<int, kDepth> open;
  size_t count = 0;
  open[count++] = 0;
  while (count > 0) {
    const int at = open[--count];
    const Node& node = nodes_[static_cast<size_t>(at)];
    if (!meets(node.box, from, inverse, reach)) continue;
    if (node.count == 0) {
      open[count++] = node.first;
      open[count++] = at + 1;
      continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) visit(order_[static_cast<size_t>(i)]);
  }
}

std::optional<double> Occlusion::meet(int polygon, const Vector3d& from, const Vector3d& direction,
                                      double reach) const {
  const Polygon& p = scene_.polygons[static_cast<size_t>(polygon)];
  const double along = p.normal.dot(direction);
  if (std::abs(along) < 1e-12) return std::nullopt;
  const double t = (p.offset - p.normal.dot(from)) / along;
  if (!(t > 0 && t < reach)) return std::nullopt;
  const Vector3d at = from + t * direction;
  bool left = false, right = false;
  for (int i = 0; i < p.count; ++i) {
    const Vector3d& a = scene_.vertices[static_cast<size_t>(p.first + i)];
    const Vector3d& b = scene_.vertices[static_cast<size_t>(p.first + (i + 1) % p.count)];
    const double side = (b - a).cross(at - a).dot(p.normal);
    left = left || side > 0;
    right = right || side < 0;
    if (left && right) return std::nullopt;
  }
  return t;
}

std::optional<Occlusion::Hit> Occlusion::first(const Vector3d& from, const Vector3d& direction, double reach,
                                               int own) const {
  std::optional<Hit> hit;
  walk(from, direction, reach, [&](int polygon) {
    if (polygon == own) return;
    if (const auto t = meet(polygon, from, direction, reach)) {
      hit = {polygon, *t};
      reach = *t;
    }
  });
  return hit;
}

bool Occlusion::blocked(const Vector3d& from, const Vector3d& to, int own) const {
  bool found = false;
  double reach = 1;
  const Vector3d direction = to - from;
  walk(from, direction, reach, [&](int polygon) {
    if (found || polygon == own || !meet(polygon, from, direction, reach)) return;
    found = true;
    reach = -1;  // ends the walk
  });
  return found;
}

}  // namespace covis::synth
