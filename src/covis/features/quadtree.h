// SPDX-License-Identifier: Apache-2.0
// Reduces the corners of one level to a budget, spread evenly over the image, by a quadtree (algorithms.md §1).
#pragma once

#include <cstdint>
#include <vector>

#include "covis/features/fast.h"

namespace covis {

class Quadtree {
 public:
  // Keeps at most budget + 3 of the corners, which lie in [x0, x1) x [y0, y1): from each final node the one with the
  // highest score (ties: least y, then least x). `kept` is sorted by y, then x. The input order does not matter;
  // positions must be distinct.
  void distribute(const std::vector<Corner>& corners, int x0, int y0, int x1, int y1, int budget,
                  std::vector<Corner>& kept);

 private:
  struct Place {
    int16_t x, y;
    uint32_t index;  // index of the corner in the order of y, then x
  };
  struct Node {
    float x0, y0, x1, y1;
    uint32_t first, last;  // range of the node's corners in places_
    bool open() const { return last - first > 1; }
  };
  // Appends the node's children that hold corners.
  void split(const Node& node, std::vector<Node>& out);
  void make_roots(int x0, int y0, int x1, int y1, int most);
  // Moves the nodes with most corners to the front; equal nodes keep their order.
  void sort_by_size();

  std::vector<Corner> sorted_;
  std::vector<Place> places_, scratch_;
  std::vector<Node> nodes_, next_;
  std::vector<uint64_t> keys_;
  std::vector<uint32_t> root_of_, starts_, best_;
};

}  // namespace covis
