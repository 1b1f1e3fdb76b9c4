// SPDX-License-Identifier: Apache-2.0
// The descriptors of some of an image's features, one after the other, so that one sweep compares them all.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "covis/features/features.h"

namespace covis {

class DescriptorSubset {
 public:
  // Those with use[i] != 0; an empty span means all (then nothing is copied).
  DescriptorSubset(const Features& features, std::span<const uint8_t> use) : all_(features.descriptor.data()) {
    if (use.empty()) {
      size_ = features.descriptor.size();
      return;
    }
    for (size_t i = 0; i < use.size(); ++i) {
      if (!use[i]) continue;
      index_.push_back(static_cast<int32_t>(i));
      copies_.push_back(features.descriptor[i]);
    }
    all_ = copies_.data();
    size_ = copies_.size();
  }

  size_t size() const { return size_; }
  const Descriptor* descriptors() const { return all_; }
  int32_t feature(size_t k) const { return index_.empty() ? static_cast<int32_t>(k) : index_[k]; }

 private:
  const Descriptor* all_;
  size_t size_ = 0;
  AlignedVector<Descriptor> copies_;
  std::vector<int32_t> index_;
};

}  // namespace covis
