// SPDX-License-Identifier: Apache-2.0
// Builds the bytes of a vocabulary file from a list of nodes.
#include <cmath>
#include <cstring>
#include <string>

#include "covis/vocabulary/vocabulary.h"
#include "covis/vocabulary/vocabulary_file.h"

namespace covis {
namespace {

// The children of each node (root first), in the order of the list.
struct Children {
  std::vector<uint32_t> offset, node;
  explicit Children(const std::vector<VocabularyNode>& nodes) : offset(nodes.size() + 2), node(nodes.size()) {
    for (const VocabularyNode& child : nodes) ++offset[child.parent + 1];
    for (size_t i = 1; i < offset.size(); ++i) offset[i] += offset[i - 1];
    std::vector<uint32_t> next(offset.begin(), offset.end() - 1);
    for (uint32_t i = 0; i < nodes.size(); ++i) node[next[nodes[i].parent]++] = i + 1;
  }
  uint32_t count(uint32_t n) const { return offset[n + 1] - offset[n]; }
};

Result<void> check_list(int branching, int depth, const std::vector<VocabularyNode>& nodes) {
  if (branching < 2 || branching > Vocabulary::kMaxBranching || depth < 1 || depth > Vocabulary::kMaxDepth) {
    return fail("a vocabulary's branching must be from 2 to " + std::to_string(Vocabulary::kMaxBranching) +
                " and its depth from 1 to " + std::to_string(Vocabulary::kMaxDepth) + ", not " +
                std::to_string(branching) + " and " + std::to_string(depth));
  }
  if (nodes.empty()) return fail("the vocabulary has no nodes");
  if (nodes.size() > (1u << 30)) return fail("the vocabulary has too many nodes");
  std::vector<uint8_t> levels(nodes.size() + 1);
  std::vector<int> children(nodes.size() + 1);
  for (size_t i = 0; i < nodes.size(); ++i) {
    const VocabularyNode& node = nodes[i];
    const std::string name = "node " + std::to_string(i + 1);
    if (node.parent > i) return fail(name + ": its parent is not listed before it");
    levels[i + 1] = static_cast<uint8_t>(levels[node.parent] + 1);
    if (levels[i + 1] > depth) return fail(name + ": it lies deeper than the depth " + std::to_string(depth));
    if (++children[node.parent] > branching)
      return fail(name + ": its parent has more than " + std::to_string(branching) + " children");
    if (!(node.weight >= 0 && node.weight <= Vocabulary::kMaxWeight))
      return fail(name + ": its weight must not be negative, nor greater than a million");
  }
  return {};
}

template <class T>
void store(AlignedVector<std::byte>& bytes, uint64_t offset, const T& value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

}  // namespace

Result<std::shared_ptr<const Vocabulary>> Vocabulary::build(int branching, int depth,
                                                            const std::vector<VocabularyNode>& nodes) {
  if (auto ok = check_list(branching, depth, nodes); !ok) return tl::unexpected(ok.error());
  const Children children(nodes);
  const auto count = static_cast<uint32_t>(nodes.size() + 1);
  uint32_t words = 0;
  for (uint32_t n = 0; n < count; ++n) words += children.count(n) == 0 ? 1 : 0;
  const VocabularyLayout layout(count, words);
  const std::shared_ptr<Vocabulary> vocabulary(new Vocabulary);
  AlignedVector<std::byte>& bytes = vocabulary->memory_;
  bytes.resize(layout.end);

  std::vector<uint32_t> order{0};  // breadth-first order
  order.reserve(count);
  uint32_t word = 0;
  for (uint32_t n = 0; n < count; ++n) {
    const uint32_t old = order[n];
    store(bytes, layout.nodes + sizeof(Node) * n, Node{static_cast<uint32_t>(order.size()), word});
    for (uint32_t k = children.offset[old]; k < children.offset[old + 1]; ++k) order.push_back(children.node[k]);
    store(bytes, layout.descriptors + sizeof(Descriptor) * n, old == 0 ? Descriptor{} : nodes[old - 1].descriptor);
    if (children.count(old) == 0) store(bytes, layout.weights + sizeof(float) * word++, nodes[old - 1].weight);
  }
  store(bytes, layout.nodes + sizeof(Node) * count, Node{count, words});

  VocabularyHeader header{};
  std::memcpy(header.magic, kVocabularyMagic.data(), kVocabularyMagic.size());
  header.version = kVocabularyVersion;
  header.branching = static_cast<uint32_t>(branching);
  header.depth = static_cast<uint32_t>(depth);
  header.nodes = count;
  header.words = words;
  header.bytes = layout.end;
  header.checksum = vocabulary_checksum(header, std::span<const std::byte>(bytes).subspan(sizeof header));
  header.header_checksum = header_checksum(header);
  store(bytes, 0, header);
  if (auto ok = vocabulary->open(bytes); !ok) return tl::unexpected(ok.error());
  return vocabulary;
}

}  // namespace covis
