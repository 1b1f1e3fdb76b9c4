// SPDX-License-Identifier: Apache-2.0
// The field's text format for vocabularies of 256-bit descriptors. First line: `k L scoring weighting`, 0 0 for the L1
// score and tf-idf weights, the only supported ones. Then one line per node: the parent's number, 1 for a word or 0,
// the descriptor's 32 bytes, the weight. Nodes are numbered from 1 in the order of lines, parents before children; 0 is
// the root, which has no line.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "covis/vocabulary/vocabulary.h"

namespace covis {

struct VocabularyText {
  int branching = 0, depth = 0;
  std::vector<VocabularyNode> nodes;
};

// Errors name the line. A node without children is a word whatever its flag; a word with children is an error.
Result<VocabularyText> parse_vocabulary_text(std::string_view text);
std::string write_vocabulary_text(const VocabularyText& text);

}  // namespace covis
