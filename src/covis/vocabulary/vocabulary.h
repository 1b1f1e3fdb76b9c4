// SPDX-License-Identifier: Apache-2.0
// A vocabulary: a tree of descriptors whose leaves are visual words, and what it says of an image.
// Sources: Nistér and Stewénius, "Scalable Recognition with a Vocabulary Tree", CVPR 2006, sections 2 to 4 (tree,
// tf-idf); Gálvez-López and Tardós, "Bags of Binary Words for Fast Place Recognition in Image Sequences", T-RO 2012,
// sections III and IV (binary words, direct index, L1 score).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "covis/core/aligned.h"
#include "covis/core/error.h"
#include "covis/features/features.h"

namespace covis {

// Features are grouped for matching by their ancestor at this level of the tree (the root is level 0): branching^2
// groups, 100 of the usual branching of 10, whatever the depth: 4 levels above the words of a tree of depth 6, 3 of 5.
inline constexpr int kDirectIndexLevel = 2;

struct WordWeight {
  uint32_t word = 0;
  float weight = 0;
  friend bool operator==(const WordWeight&, const WordWeight&) = default;
};

// An image in words of the vocabulary.
struct Words {
  std::vector<WordWeight> words;  // tf-idf, rising by word; weights sum to 1 (L1); words of weight 0 are left out
  friend bool operator==(const Words&, const Words&) = default;
};

// An image's features by their ancestors at kDirectIndexLevel. (Nothing in Covis matches by it: docs/results.md says
// what it finds and what it costs beside comparing all.)
struct DirectIndex {
  std::vector<uint32_t> node;     // distinct ancestor nodes, rising
  std::vector<uint32_t> offset;   // node[k]'s features are feature[offset[k] .. offset[k + 1])
  std::vector<uint32_t> feature;  // rising within a node
  friend bool operator==(const DirectIndex&, const DirectIndex&) = default;
};

// 1 - |a - b|_1 / 2 (Gálvez-López and Tardós 2012, eq. 2): 1 for equal, 0 for nothing in common.
double word_score(const std::vector<WordWeight>& a, const std::vector<WordWeight>& b);

// A node of a tree that is being built. Nodes count from 1 in the order of their list; 0 is the root, which is not in
// it.
struct VocabularyNode {
  Descriptor descriptor;
  uint32_t parent = 0;  // less than the node's own number
  float weight = 0;     // idf of a word (a node without children); not read of others
};

class MappedFile;

// Immutable; any number of threads may use it at once.
class Vocabulary {
 public:
  static constexpr int kMaxBranching = 256, kMaxDepth = 16;

  // The binary format (mapped: the file must not be written to in place afterwards; save() never does) or the field's
  // text format, recognised by content. The binary file's sizes, indices and weights are checked, not its checksum:
  // verify().
  static Result<std::shared_ptr<const Vocabulary>> load(const std::filesystem::path& file);
  // Words are numbered breadth first. An error names the node that is wrong.
  static Result<std::shared_ptr<const Vocabulary>> build(int branching, int depth,
                                                         const std::vector<VocabularyNode>& nodes);

  Vocabulary(const Vocabulary&) = delete;
  Vocabulary& operator=(const Vocabulary&) = delete;
  ~Vocabulary();

  // Binary, to a temporary name, then renamed.
  Result<void> save(const std::filesystem::path& file) const;
  // The field's text format, the same way.
  Result<void> save_text(const std::filesystem::path& file) const;

  // The word a descriptor falls to: from the root down, each time to the nearest child (the first on a tie).
  uint32_t word(const Descriptor& descriptor) const;
  Words transform(std::span<const Descriptor> descriptors) const;
  DirectIndex direct_index(std::span<const Descriptor> descriptors) const;

  int branching() const { return branching_; }                                   // most children of a node
  int depth() const { return depth_; }                                           // most levels below the root
  uint32_t words() const { return static_cast<uint32_t>(weights_.size()); }      // words are 0 .. words() - 1
  uint32_t nodes() const { return static_cast<uint32_t>(descriptors_.size()); }  // with the root
  float weight(uint32_t word) const { return weights_[word]; }                   // its idf
  uint64_t checksum() const {
    return checksum_;
  }                     // checksum of the content, as the header says it: names it in saved maps
  bool verify() const;  // true when the content has that checksum (reads all of it)

 private:
  // Nodes are numbered breadth first, so that the children of a node follow each other: those of n are
  // [nodes_[n].child, nodes_[n + 1].child). One more entry ends the list.
  struct Node {
    uint32_t child;  // its first child
    uint32_t word;   // words among the nodes before it; of a word: its number
  };
  struct Leaf {
    uint32_t word, direct_node;
  };

  Vocabulary();
  Leaf descend(const Descriptor& descriptor) const;
  Result<void> open(std::span<const std::byte> bytes);  // points into a whole file's bytes, after checking them
  Result<void> check_nodes() const;

  int branching_ = 0, depth_ = 0;
  uint64_t checksum_ = 0;
  std::span<const std::byte> bytes_;         // the whole file
  std::span<const Descriptor> descriptors_;  // descriptors of nodes; the root's is zero
  std::span<const Node> nodes_;
  std::span<const float> weights_;      // weights of words
  AlignedVector<std::byte> memory_;     // holds the bytes, or …
  std::unique_ptr<MappedFile> mapped_;  // … they are mapped
};

}  // namespace covis
