// SPDX-License-Identifier: Apache-2.0
#include "covis/vocabulary/vocabulary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "covis/core/atomic_file.h"
#include "covis/core/mapped_file.h"
#include "covis/features/hamming.h"
#include "covis/vocabulary/vocabulary_file.h"
#include "covis/vocabulary/vocabulary_text.h"

namespace covis {
namespace {

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Views an array inside a file's bytes.
template <class T>
std::span<const T> array_at(std::span<const std::byte> bytes, uint64_t offset, size_t count) {
  static_assert(std::is_trivially_copyable_v<T>);
  return {reinterpret_cast<const T*>(bytes.data() + offset), count};
}

VocabularyHeader header_of(std::span<const std::byte> bytes) {
  VocabularyHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  return header;
}

Result<void> check_header(const VocabularyHeader& header, uint64_t bytes) {
  if (header.header_checksum != header_checksum(header)) return fail("its header is damaged (checksum)");
  if (header.version != kVocabularyVersion) {
    return fail("it has version " + std::to_string(header.version) + "; this program reads version " +
                std::to_string(kVocabularyVersion));
  }
  if (header.branching < 2 || header.branching > Vocabulary::kMaxBranching || header.depth < 1 ||
      header.depth > Vocabulary::kMaxDepth || header.nodes < 2 || header.words < 1 || header.words >= header.nodes ||
      header.bytes != VocabularyLayout(header.nodes, header.words).end) {
    return fail("its header has impossible sizes");
  }
  if (bytes != header.bytes) {
    return fail(std::string(bytes < header.bytes ? "it is cut short" : "something follows its end") + " (" +
                std::to_string(bytes) + " bytes of " + std::to_string(header.bytes) + ")");
  }
  return {};
}

}  // namespace

WeightsByWord::WeightsByWord(const std::vector<WordWeight>& words) {
  if (!words.empty()) weight_.resize(words.back().word + size_t{1});
  for (const WordWeight& w : words) weight_[w.word] = w.weight;
}

double WeightsByWord::score(const std::vector<WordWeight>& other) const {
  double score = 0;  // both sum to 1, so it is the sum of the smaller weights of the common words
  for (const WordWeight& w : other) {
    if (w.word >= weight_.size()) break;
    score += std::min(weight_[w.word], w.weight);
  }
  return score;
}

Result<std::shared_ptr<const Vocabulary>> Vocabulary::load(const std::filesystem::path& file) {
  auto mapped = MappedFile::open(file);
  if (!mapped) return tl::unexpected(mapped.error());
  const std::span<const std::byte> bytes = (*mapped)->bytes();
  if (bytes.empty()) return fail(file.string() + ": the file is empty");
  const auto named = [&](const Error& error) { return fail(file.string() + ": " + error.message); };
  const size_t magic = std::min(bytes.size(), kVocabularyMagic.size());
  if (text_of(bytes).substr(0, magic) != kVocabularyMagic.substr(0, magic)) {
    const auto text = parse_vocabulary_text(text_of(bytes));
    if (!text) return named(text.error());
    auto built = build(text->branching, text->depth, text->nodes);
    if (!built) return named(built.error());
    return built;
  }
  const std::shared_ptr<Vocabulary> vocabulary(new Vocabulary);
  // A copy: who cuts the file short later must not end the process.
  vocabulary->memory_.assign(bytes.begin(), bytes.end());
  if (auto ok = vocabulary->open(vocabulary->memory_); !ok) return named(ok.error());
  if (!vocabulary->verify()) return named({"the vocabulary can't be used: its content is damaged (checksum)"});
  return vocabulary;
}

Result<void> Vocabulary::open(std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof(VocabularyHeader)) return fail("the vocabulary is cut short within its header");
  const VocabularyHeader header = header_of(bytes);
  if (auto ok = check_header(header, bytes.size()); !ok)
    return fail("the vocabulary can't be used: " + ok.error().message);
  const VocabularyLayout layout(header.nodes, header.words);
  branching_ = static_cast<int>(header.branching);
  depth_ = static_cast<int>(header.depth);
  checksum_ = header.checksum;
  bytes_ = bytes;
  descriptors_ = array_at<Descriptor>(bytes, layout.descriptors, header.nodes);
  nodes_ = array_at<Node>(bytes, layout.nodes, size_t{header.nodes} + 1);
  weights_ = array_at<float>(bytes, layout.weights, header.words);
  return check_nodes();
}

// Checks all that descend() and transform() rely on, whatever the checksum says.
Result<void> Vocabulary::check_nodes() const {
  const uint32_t count = nodes();
  bool good =
      nodes_[0].child == 1 && nodes_[0].word == 0 && nodes_[count].child == count && nodes_[count].word == words();
  for (uint32_t n = 0; n < count; ++n) {
    const uint32_t first = nodes_[n].child, last = nodes_[n + 1].child;
    good &= first > n && last >= first && last <= count && last - first <= static_cast<uint32_t>(branching_);
    good &= nodes_[n + 1].word == nodes_[n].word + (first == last ? 1 : 0);
  }
  uint32_t begin = 0, end = 1;  // range of the nodes of a level
  for (int level = 0; good && level < depth_ && begin < end; ++level) {
    begin = std::exchange(end, nodes_[end].child);
  }
  good &= end == count;
  for (const float weight : weights_) good &= weight >= 0 && weight <= kMaxWeight;  // a NaN is not
  return good ? Result<void>() : fail("the vocabulary can't be used: its tree is damaged");
}

bool Vocabulary::verify() const {
  return vocabulary_checksum(header_of(bytes_), bytes_.subspan(sizeof(VocabularyHeader))) == checksum_;
}

Result<void> Vocabulary::save(const std::filesystem::path& file) const {
  return write_atomically(file, text_of(bytes_), Durability::durable);
}

Result<void> Vocabulary::save_text(const std::filesystem::path& file) const {
  VocabularyText text{branching_, depth_, std::vector<VocabularyNode>(nodes() - 1)};
  for (uint32_t n = 0; n < nodes(); ++n) {
    const bool leaf = nodes_[n].child == nodes_[n + 1].child;
    if (n > 0) text.nodes[n - 1].descriptor = descriptors_[n];
    if (leaf) text.nodes[n - 1].weight = weights_[nodes_[n].word];
    for (uint32_t child = nodes_[n].child; child < nodes_[n + 1].child; ++child) text.nodes[child - 1].parent = n;
  }
  return write_atomically(file, write_vocabulary_text(text), Durability::durable);
}

std::vector<uint32_t> Vocabulary::descend(std::span<const Descriptor> descriptors, int levels) const {
  constexpr size_t kTogether = 32, kLine = 64 / sizeof(Descriptor);
  std::array<uint16_t, kMaxBranching> distance;
  std::vector<uint32_t> nodes(descriptors.size());
  for (size_t begin = 0; begin < nodes.size(); begin += kTogether) {
    const size_t end = std::min(begin + kTogether, nodes.size());
    for (int level = 0; level < levels; ++level) {
      for (size_t i = begin; i < end; ++i) {
        for (uint32_t child = nodes_[nodes[i]].child; child < nodes_[nodes[i] + 1].child; child += kLine)
          __builtin_prefetch(&descriptors_[child]);
      }
      for (size_t i = begin; i < end; ++i) {
        const uint32_t first = nodes_[nodes[i]].child;
        const auto children = static_cast<int>(nodes_[nodes[i] + 1].child - first);
        if (children == 0) continue;
        hamming_row(descriptors[i], &descriptors_[first], children, distance.data());
        const auto* const nearest = std::min_element(distance.data(), distance.data() + children);
        nodes[i] = first + static_cast<uint32_t>(nearest - distance.data());
      }
    }
  }
  return nodes;
}

uint32_t Vocabulary::word(const Descriptor& descriptor) const {
  return nodes_[descend({&descriptor, 1}, depth_).front()].word;
}

Words Vocabulary::transform(std::span<const Descriptor> descriptors) const {
  std::vector<uint32_t> words = descend(descriptors, depth_);
  for (uint32_t& node : words) node = nodes_[node].word;
  std::sort(words.begin(), words.end());
  Words out;
  double sum = 0;
  for (size_t i = 0; i < words.size();) {  // tf-idf; the normalisation cancels the number of features
    size_t end = i + 1;
    while (end < words.size() && words[end] == words[i]) ++end;
    const float weight = static_cast<float>(end - i) * weights_[words[i]];
    if (weight > 0) out.words.push_back({words[i], weight});
    sum += weight;
    i = end;
  }
  for (WordWeight& word : out.words) word.weight = static_cast<float>(word.weight / sum);
  out.words.shrink_to_fit();  // most of these vectors are kept
  return out;
}

DirectIndex Vocabulary::direct_index(std::span<const Descriptor> descriptors) const {
  const std::vector<uint32_t> nodes = descend(descriptors, kDirectIndexLevel);
  std::vector<uint64_t> keys(nodes.size());  // high half: node, low half: feature
  for (size_t i = 0; i < keys.size(); ++i) keys[i] = (uint64_t{nodes[i]} << 32) | i;
  std::sort(keys.begin(), keys.end());
  DirectIndex index;
  for (size_t i = 0; i < keys.size(); ++i) {
    const auto node = static_cast<uint32_t>(keys[i] >> 32);
    index.feature.push_back(static_cast<uint32_t>(keys[i]));
    if (i > 0 && node == index.node.back()) continue;
    index.node.push_back(node);
    index.offset.push_back(static_cast<uint32_t>(i));
  }
  index.offset.push_back(static_cast<uint32_t>(keys.size()));
  return index;
}

}  // namespace covis
