// SPDX-License-Identifier: Apache-2.0
// Rays against a scene: what stands between a surface and a light. Polygons are looked up in a tree of boxes. Sources:
// Kay and Kajiya, "Ray tracing complex scenes", SIGGRAPH 1986 (trees of boxes); Snyder and Barr, "Ray tracing complex
// models containing surface tessellations", SIGGRAPH 1987 (the plane first, then the outline).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "synth/render/scene.h"

namespace covis::synth {

class Occlusion {
 public:
  // The sky is left out. The scene has to stay as it is, and where it is.
  explicit Occlusion(const Scene& scene);

  struct Hit {
    int polygon;      // index in Scene::polygons
    double distance;  // in lengths of `direction`
  };
  // Returns the first polygon along from + t * direction, 0 < t < reach, seen from either side; `own` is left out (-1:
  // none).
  std::optional<Hit> first(const Vector3d& from, const Vector3d& direction, double reach, int own) const;
  // True when any polygon but `own` stands between the two points.
  bool blocked(const Vector3d& from, const Vector3d& to, int own) const;

 private:
  struct Box {
    Vector3d low, high;
  };
  // A leaf has `count` polygons from order_[first] on. Of an inner node, `first` is the right child; the left one
  // follows the node.
  struct Node {
    Box box;
    int first, count;
  };
  void build(const std::vector<Box>& boxes, int begin, int end);
  // Calls visit(polygon) for each polygon whose box the ray may meet before `reach`, which visit() may lower.
  template <class Visit>
  void walk(const Vector3d& from, const Vector3d& direction, const double& reach, Visit&& visit) const;
  std::optional<double> meet(int polygon, const Vector3d& from, const Vector3d& direction, double reach) const;

  const Scene& scene_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace covis::synth
