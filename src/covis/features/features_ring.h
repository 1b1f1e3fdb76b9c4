// SPDX-License-Identifier: Apache-2.0
// Features objects that are used again once nobody holds them, so that a frame's features cost no allocation.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "covis/features/features.h"

namespace covis {

// The tracker holds those of two frames, and of up to 540 while the camera is lost or its place is in doubt; the
// monitor those of two frames while motion contradicts depth; mapping those of new key frames.
class FeaturesRing {
 public:
  explicit FeaturesRing(size_t size = 3) : ring_(size) {}

  // Returns an object that nobody else holds, with whatever it was last used for.
  std::shared_ptr<Features> next() {
    at_ = (at_ + 1) % ring_.size();
    // Copying the shared pointer synchronises with the release by its last other owner, in whatever thread that was.
    std::shared_ptr<Features> copy = ring_[at_];
    if (copy.use_count() == 2) return copy;
    return ring_[at_] = std::make_shared<Features>();
  }
  // The same of a copy of these, with patches of its own.
  std::shared_ptr<Features> copy_of(const Features& features);

 private:
  std::vector<std::shared_ptr<Features>> ring_;
  size_t at_ = 0;
};

}  // namespace covis
