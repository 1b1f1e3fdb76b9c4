// SPDX-License-Identifier: Apache-2.0
#include "covis/vocabulary/kmedians.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <mutex>
#include <utility>

#include "covis/features/hamming.h"

namespace covis {
namespace {

// Counts for each bit how many of a cluster's members have it set.
class BitCounts {
 public:
  void add(const Descriptor& descriptor) {
    std::array<uint8_t, 32> bytes;
    std::memcpy(bytes.data(), descriptor.bits.data(), bytes.size());
    for (size_t i = 0; i < bytes.size(); ++i) lanes_[i] += kSpread[bytes[i]];
    ++members_;
    if (++pending_ == 255) flush();
  }
  void add(BitCounts& other) {
    flush();
    other.flush();
    for (size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
    members_ += other.members_;
  }
  uint64_t members() const { return members_; }
  // Returns the bits set in more than half of the members; a bit set in exactly half keeps its value in `before`.
  Descriptor majority(const Descriptor& before) {
    flush();
    Descriptor out;
    for (size_t i = 0; i < counts_.size(); ++i) {
      const uint64_t twice = 2 * counts_[i], mask = uint64_t{1} << (i % 64);
      if (twice > members_ || (twice == members_ && (before.bits[i / 64] & mask) != 0)) out.bits[i / 64] |= mask;
    }
    return out;
  }

 private:
  // Spreads bit b of the index to byte b.
  static constexpr std::array<uint64_t, 256> kSpread = [] {
    std::array<uint64_t, 256> table{};
    for (size_t value = 0; value < 256; ++value) {
      for (size_t b = 0; b < 8; ++b) table[value] |= uint64_t{(value >> b) & 1} << (8 * b);
    }
    return table;
  }();

  void flush() {
    for (size_t i = 0; i < counts_.size(); ++i) counts_[i] += (lanes_[i / 8] >> (8 * (i % 8))) & 0xff;
    lanes_ = {};
    pending_ = 0;
  }

  std::array<uint64_t, 32> lanes_{};  // eight counts of one byte each, up to 255
  int pending_ = 0;                   // number of members counted in lanes_
  uint64_t members_ = 0;
  std::array<uint64_t, 256> counts_{};
};

class KMedians {
 public:
  KMedians(std::span<const Descriptor> descriptors, std::span<const uint32_t> members, const ForRanges& for_ranges)
      : descriptors_(descriptors), members_(members), for_ranges_(for_ranges) {
    clusters_.of.assign(members.size(), 0);
  }

  Clusters run(int k, int iterations, Random& random) {
    seed(k, random);
    for (int round = 0; round < iterations; ++round) {
      if (!move_centres()) break;
      if (!assign()) break;
    }
    drop_empty();
    return std::move(clusters_);
  }

 private:
  const Descriptor& member(size_t i) const { return descriptors_[members_[i]]; }

  // Chooses each centre among the members with a probability proportional to the distance to the nearest centre so far.
  // Assigns every member to its nearest centre.
  void seed(int k, Random& random) {
    std::vector<uint16_t> nearest(members_.size(), kHammingBeyond);
    size_t next = static_cast<size_t>(random.uniform() * static_cast<double>(members_.size()));
    while (true) {
      const auto c = static_cast<uint8_t>(clusters_.centres.size());
      clusters_.centres.push_back(member(next));
      std::atomic<uint64_t> total = 0;
      for_ranges_(members_.size(), [&](size_t begin, size_t end) {
        uint64_t sum = 0;
        for (size_t i = begin; i < end; ++i) {
          const auto distance = static_cast<uint16_t>(hamming(member(i), clusters_.centres[c]));
          if (distance < nearest[i]) {
            nearest[i] = distance;
            clusters_.of[i] = c;
          }
          sum += nearest[i];
        }
        total += sum;
      });
      if (total == 0 || clusters_.centres.size() == static_cast<size_t>(k)) return;
      auto draw = static_cast<uint64_t>(random.uniform() * static_cast<double>(total.load()));
      draw = std::min(draw, total - 1);
      for (next = 0; draw >= nearest[next]; ++next) draw -= nearest[next];
    }
  }

  // Returns true when a centre moved.
  bool move_centres() {
    const size_t k = clusters_.centres.size();
    std::vector<BitCounts> all(k);
    std::mutex mutex;
    for_ranges_(members_.size(), [&](size_t begin, size_t end) {
      std::vector<BitCounts> some(k);
      for (size_t i = begin; i < end; ++i) some[clusters_.of[i]].add(member(i));
      const std::lock_guard lock(mutex);
      for (size_t c = 0; c < k; ++c) all[c].add(some[c]);
    });
    bool moved = false;
    for (size_t c = 0; c < k; ++c) {
      if (all[c].members() == 0) continue;
      const Descriptor median = all[c].majority(clusters_.centres[c]);
      moved |= !(median == clusters_.centres[c]);
      clusters_.centres[c] = median;
    }
    return moved;
  }

  // Returns true when a member changed its cluster.
  bool assign() {
    std::atomic<bool> changed = false;
    const auto k = static_cast<int>(clusters_.centres.size());
    for_ranges_(members_.size(), [&](size_t begin, size_t end) {
      std::array<uint16_t, 256> distance;
      for (size_t i = begin; i < end; ++i) {
        hamming_row(member(i), clusters_.centres.data(), k, distance.data());
        const auto c = static_cast<uint8_t>(std::min_element(distance.data(), distance.data() + k) - distance.data());
        if (c == clusters_.of[i]) continue;
        clusters_.of[i] = c;
        changed = true;
      }
    });
    return changed;
  }

  // Renumbers the clusters that have members, in their order. Of two equal centres the second has no members.
  void drop_empty() {
    std::vector<int> number(clusters_.centres.size(), 0);
    for (const uint8_t c : clusters_.of) number[c] = 1;
    size_t kept = 0;
    for (size_t c = 0; c < number.size(); ++c) {
      if (number[c] == 0) continue;
      clusters_.centres[kept] = clusters_.centres[c];
      number[c] = static_cast<int>(kept++);
    }
    clusters_.centres.resize(kept);
    for (uint8_t& c : clusters_.of) c = static_cast<uint8_t>(number[c]);
  }

  std::span<const Descriptor> descriptors_;
  std::span<const uint32_t> members_;
  const ForRanges& for_ranges_;
  Clusters clusters_;
};

}  // namespace

Clusters k_medians(std::span<const Descriptor> descriptors, std::span<const uint32_t> members, int k, int iterations,
                   Random& random, const ForRanges& for_ranges) {
  return KMedians(descriptors, members, for_ranges).run(k, iterations, random);
}

}  // namespace covis
