// SPDX-License-Identifier: Apache-2.0
// A vocabulary: a tree of descriptors whose leaves are visual words, and its description of an image.
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
// groups, 100 for the usual branching of 10, whatever the depth: 4 levels above the words of a tree of depth 6, 3 of
// depth 5.
inline constexpr int kDirectIndexLevel = 2;

struct WordWeight {
  uint32_t word = 0;
  float weight = 0;
  friend bool operator==(const WordWeight&, const WordWeight&) = default;
};

// The bag of words of an image.
struct Words {
  std::vector<WordWeight> words;  // tf-idf, ascending by word; weights sum to 1 (L1); words of weight 0 are left out
  friend bool operator==(const Words&, const Words&) = default;
};

// An image's features grouped by their ancestors at kDirectIndexLevel. (Covis itself does not use it for matching:
// docs/notes/007-matching-by-words.md compares it with comparing all features.)
struct DirectIndex {
  std::vector<uint32_t> node;     // distinct ancestor nodes, ascending
  std::vector<uint32_t> offset;   // the features of node[k] are feature[offset[k] .. offset[k + 1])
  std::vector<uint32_t> feature;  // ascending within a node
  friend bool operator==(const DirectIndex&, const DirectIndex&) = default;
};

// The weights of one image's words (Words::words, ascending) in an array by word, to compare the image with others.
class WeightsByWord {
 public:
  explicit WeightsByWord(const std::vector<WordWeight>& words);
  // Returns 1 - |a - b|_1 / 2 (Gálvez-López and Tardós 2012, eq. 2), where b are the words of another image: 1 for
  // equal images, 0 without common words. It is the same either way round, to the bit.
  double score(const std::vector<WordWeight>& other) const;

 private:
  std::vector<float> weight_;  // by word
};

// A node of a tree under construction. Nodes are numbered from 1 in the order of their list; 0 is the root, which is
// not listed.
struct VocabularyNode {
  Descriptor descriptor;
  uint32_t parent = 0;  // less than the node's own number
  float weight = 0;     // idf of a word (a node without children); ignored for other nodes
};

// Immutable; any number of threads may use it at once.
class Vocabulary {
 public:
  static constexpr int kMaxBranching = 256, kMaxDepth = 16;
  static constexpr float kMaxWeight = 1e6f;  // the logarithm of any number of images is far below

  // Loads the binary format or the field's text format, recognised by content. All of it is checked, the checksum of a
  // binary file included, so that a damaged vocabulary never passes for the one whose checksum it has. The file is
  // copied into memory: what happens to it later changes nothing.
  static Result<std::shared_ptr<const Vocabulary>> load(const std::filesystem::path& file);
  // Numbers words breadth first. An error names the invalid node.
  static Result<std::shared_ptr<const Vocabulary>> build(int branching, int depth,
                                                         const std::vector<VocabularyNode>& nodes);

  Vocabulary(const Vocabulary&) = delete;
  Vocabulary& operator=(const Vocabulary&) = delete;

  // Writes the binary format to a temporary file and renames it.
  Result<void> save(const std::filesystem::path& file) const;
  // Writes the field's text format in the same way.
  Result<void> save_text(const std::filesystem::path& file) const;

  // Returns the word of a descriptor: descends from the root, each time to the nearest child (the first on a tie).
  uint32_t word(const Descriptor& descriptor) const;
  Words transform(std::span<const Descriptor> descriptors) const;
  DirectIndex direct_index(std::span<const Descriptor> descriptors) const;

  int branching() const { return branching_; }                                   // most children of a node
  int depth() const { return depth_; }                                           // most levels below the root
  uint32_t words() const { return static_cast<uint32_t>(weights_.size()); }      // words are 0 .. words() - 1
  uint32_t nodes() const { return static_cast<uint32_t>(descriptors_.size()); }  // includes the root
  float weight(uint32_t word) const { return weights_[word]; }                   // idf of the word
  // Returns the checksum of the content, from the header. It identifies the vocabulary in saved maps.
  uint64_t checksum() const { return checksum_; }
  bool verify() const;  // checks the checksum (reads all content)

 private:
  // Nodes are numbered breadth first, so that the children of a node are contiguous: those of n are [nodes_[n].child,
  // nodes_[n + 1].child). An extra entry ends the list.
  struct Node {
    uint32_t child;  // first child
    uint32_t word;   // number of words among the earlier nodes, which is a word's own number
  };

  Vocabulary() = default;
  // Returns the node of each descriptor after so many levels, or the leaf above. The descriptors descend side by side,
  // so that they wait for memory together.
  std::vector<uint32_t> descend(std::span<const Descriptor> descriptors, int levels) const;
  Result<void> open(std::span<const std::byte> bytes);  // checks a whole file's bytes, and points into them
  Result<void> check_nodes() const;

  int branching_ = 0, depth_ = 0;
  uint64_t checksum_ = 0;
  std::span<const std::byte> bytes_;         // bytes of the whole file
  std::span<const Descriptor> descriptors_;  // one per node; the root's is zero
  std::span<const Node> nodes_;
  std::span<const float> weights_;   // one per word
  AlignedVector<std::byte> memory_;  // holder of the bytes
};

}  // namespace covis
