// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/fuse_memory.h"

#include "covis/core/reserve.h"

namespace covis {

bool FuseMemory::has(KeyFrameId target, MapPointId point) const {
  if (target.slot >= words_.size() || point.slot / 64 >= words_[target.slot].size()) return false;
  return words_[target.slot][point.slot / 64] >> (point.slot % 64) & 1;
}

void FuseMemory::add(KeyFrameId target, MapPointId point) {
  if (size_ > kWords) {
    words_.clear();
    size_ = 0;
  }
  std::vector<uint64_t>& words = at_slot(words_, target.slot);
  const size_t before = words.size();
  at_slot(words, point.slot / 64) |= uint64_t{1} << (point.slot % 64);
  size_ += words.size() - before;
}

}  // namespace covis
