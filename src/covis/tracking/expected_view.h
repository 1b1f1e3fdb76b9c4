// SPDX-License-Identifier: Apache-2.0
// The points of the local map that a frame at its pose should show: those in view that nothing nearer covers. A thing
// that comes between the camera and known points hides them, and they are not expected to match. They still count as
// visible (docs/notes/022-a-pose-explains-its-view.md).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "covis/tracking/local_map.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

class ExpectedView {
 public:
  ExpectedView();
  // `in_view`: a flag for each point of the local map. The frame's keypoints with depth, and its matched points, show
  // how far one can see in each part of the image. Returns the number of matches that are usual for the points it
  // should show.
  double look(const LocalMap& local_map, std::span<const uint8_t> in_view, const TrackedFrame& frame,
              const Pinhole& camera);

  // A flag for each point of the local map.
  const std::vector<uint8_t>& points() const { return points_; }

 private:
  static constexpr int kColumns = 16, kRows = 12;
  struct Cell {
    int seen = 0;         // keypoints of which the depth is known
    double farthest = 0;  // their greatest depth
  };
  Cell* cell(const ImageBounds& image, double u, double v);
  void measure(const TrackedFrame& frame);

  std::array<Cell, size_t{kColumns} * kRows> cells_;
  std::vector<uint8_t> points_;
};

}  // namespace covis
