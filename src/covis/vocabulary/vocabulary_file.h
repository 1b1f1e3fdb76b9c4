// SPDX-License-Identifier: Apache-2.0
// The binary file of a vocabulary: a header, then flat arrays that are used where they lie (docs/vocabulary.md has the
// layout). Little-endian.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace covis {

inline constexpr std::string_view kVocabularyMagic{"COVISVOC", 8};
inline constexpr uint32_t kVocabularyVersion = 1;

struct VocabularyHeader {
  char magic[8];
  uint32_t version;
  uint32_t branching;
  uint32_t depth;
  uint32_t nodes;  // with the root
  uint32_t words;
  uint32_t reserved;         // 0
  uint64_t bytes;            // size of the whole file
  uint64_t checksum;         // checksum of the content: vocabulary_checksum()
  uint64_t reserved_too;     // 0
  uint64_t header_checksum;  // checksum of the bytes before it
};
static_assert(sizeof(VocabularyHeader) == 64);

// The starts of the arrays, from the numbers of nodes and words.
struct VocabularyLayout {
  uint64_t descriptors, nodes, weights, end;  // bytes from the file's start
  VocabularyLayout(uint64_t node_count, uint64_t word_count);
};

uint64_t header_checksum(const VocabularyHeader& header);
// Checksum of the sizes in the header and all that follows it.
uint64_t vocabulary_checksum(const VocabularyHeader& header, std::span<const std::byte> content);

}  // namespace covis
