// SPDX-License-Identifier: Apache-2.0
#include "covis/features/features_ring.h"

#include <utility>

#include "covis/core/reserve.h"

namespace covis {

std::shared_ptr<Features> FeaturesRing::copy_of(const Features& features) {
  std::shared_ptr<Features> copy = next();
  if (const size_t n = features.x.size(); copy->x.capacity() < n) {
    using Raw = Features::RawPixels;
    copy->start(n + n / 2, features.raw_x.empty() ? Raw::same : Raw::different);
  }
  std::shared_ptr<Patches> own = std::move(copy->patches);
  *copy = features;
  if (features.patches) {
    copy->patches = held_alone(std::move(own));
    reserve_ahead(copy->patches->at, features.patches->at.size());
    *copy->patches = *features.patches;
  }
  return copy;
}

}  // namespace covis
