// SPDX-License-Identifier: Apache-2.0
#include "covis/vocabulary/vocabulary_file.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "covis/core/random.h"

namespace covis {

static_assert(std::endian::native == std::endian::little, "vocabulary files are little-endian and used in place");

namespace {

// Hashes with four interleaved chains of mixed words, which have no dependencies between them.
uint64_t hash_bytes(uint64_t seed, std::span<const std::byte> bytes) {
  uint64_t lanes[4] = {mix64(seed), mix64(seed + 1), mix64(seed + 2), mix64(seed + 3)};
  size_t lane = 0, at = 0;
  for (; at < bytes.size(); at += 8, lane = (lane + 1) % 4) {
    uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min<size_t>(8, bytes.size() - at));
    lanes[lane] = mix64(lanes[lane] ^ word);
  }
  uint64_t hash = mix64(bytes.size());
  for (const uint64_t value : lanes) hash = mix64(hash ^ value);
  return hash;
}

}  // namespace

VocabularyLayout::VocabularyLayout(uint64_t node_count, uint64_t word_count)
    : descriptors(sizeof(VocabularyHeader)),
      nodes(descriptors + 32 * node_count),
      weights(nodes + 8 * (node_count + 1)),
      end(weights + 4 * word_count) {}

uint64_t header_checksum(const VocabularyHeader& header) {
  return hash_bytes(1, std::as_bytes(std::span(&header, 1)).first(offsetof(VocabularyHeader, header_checksum)));
}

uint64_t vocabulary_checksum(const VocabularyHeader& header, std::span<const std::byte> content) {
  uint64_t seed = 2;
  for (const uint64_t size : {header.branching, header.depth, header.nodes, header.words}) seed = mix64(seed ^ size);
  return hash_bytes(seed, content);
}

}  // namespace covis
