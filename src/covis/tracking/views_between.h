// SPDX-License-Identifier: Apache-2.0
// Chooses between the motions that two views of a plane leave open. A homography has two motions, each with a plane of
// its own, that explain both views equally well (Faugeras and Lustman, 1988; Hartley and Zisserman, "Multiple View
// Geometry", 2004, 13.1). The views in between tell them apart, unless the camera goes straight on: a rigid camera sees
// the right plane from somewhere in each of them, and the wrong one in none. Measured:
// docs/notes/048-a-start-on-a-plane.md.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "covis/core/time.h"
#include "covis/geometry/two_view.h"

namespace covis {

class ViewsBetween {
 public:
  // A feature of the first view in a later one.
  struct Sighting {
    uint32_t feature = 0;
    float u = 0, v = 0;    // pixels
    float inv_sigma2 = 0;  // 1 / pixels^2
  };

  // Begins anew with a first view of this stamp.
  void restart(Timestamp first);
  // True for a view that is to be added: few that are spread over the time suffice.
  bool is_next_due();
  void add(Timestamp stamp, std::vector<Sighting> seen);
  // The motion to the second view, of this stamp, that explains the views in between clearly better than the others do;
  // null if there is none. `feature`: the first view's feature of each match of the motions.
  const TwoViewMotion* choose(std::span<const TwoViewMotion> motions, std::span<const uint32_t> feature,
                              const Pinhole& camera, Timestamp second) const;

 private:
  struct View {
    Timestamp stamp = 0;
    std::vector<Sighting> seen;
  };

  Timestamp first_ = 0;
  std::vector<View> views_;  // evenly spread over the time since the first view
  int every_ = 1, passed_over_ = 0;
};

}  // namespace covis
