// SPDX-License-Identifier: Apache-2.0
#include "covis/vocabulary/vocabulary_text.h"

#include <array>
#include <charconv>
#include <cstring>
#include <system_error>

namespace covis {
namespace {

// Returns the next line without trailing blanks and removes it from the text.
std::string_view take_line(std::string_view& text) {
  const size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
  return line;
}

// Returns the next number of a line.
template <class T>
bool take(std::string_view& line, T& value) {
  while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
  if (error != std::errc() || (end != line.data() + line.size() && *end != ' ' && *end != '\t')) return false;
  line.remove_prefix(static_cast<size_t>(end - line.data()));
  return true;
}

bool take_node(std::string_view line, VocabularyNode& node, int& word) {
  std::array<uint8_t, 32> bytes;
  if (!take(line, node.parent) || !take(line, word) || word < 0 || word > 1) return false;
  for (uint8_t& byte : bytes) {
    if (!take(line, byte)) return false;
  }
  std::memcpy(node.descriptor.bits.data(), bytes.data(), bytes.size());
  return take(line, node.weight) && line.empty();
}

template <class T>
void put(std::string& out, T value, char end) {
  std::array<char, 32> digits;
  const auto result = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  out.append(digits.data(), result.ptr);
  out.push_back(end);
}

// Marks the nodes that have children.
std::vector<bool> find_parents(const std::vector<VocabularyNode>& nodes) {
  std::vector<bool> has(nodes.size() + 1);
  for (const VocabularyNode& node : nodes) has[node.parent] = true;
  return has;
}

}  // namespace

Result<VocabularyText> parse_vocabulary_text(std::string_view text) {
  VocabularyText out;
  std::string_view line = take_line(text);
  int scoring = 0, weighting = 0;
  if (!take(line, out.branching) || !take(line, out.depth) || !take(line, scoring) || !take(line, weighting) ||
      !line.empty()) {
    return fail(
        "it is no vocabulary: neither Covis' binary format nor text with `k L scoring weighting` in its first line");
  }
  if (scoring != 0 || weighting != 0) {
    return fail("line 1: scoring " + std::to_string(scoring) + " and weighting " + std::to_string(weighting) +
                "; only 0 (L1) and 0 (tf-idf) can be used");
  }
  std::vector<bool> words;
  for (size_t number = 2; !text.empty(); ++number) {
    line = take_line(text);
    if (line.empty()) continue;
    VocabularyNode node;
    int word = 0;
    if (!take_node(line, node, word)) {
      return fail("line " + std::to_string(number) +
                  ": it must hold the parent, 0 or 1 for a word, 32 bytes of the descriptor and the weight");
    }
    if (node.parent > out.nodes.size()) {
      return fail("line " + std::to_string(number) + ": its parent " + std::to_string(node.parent) +
                  " is not listed before it");
    }
    if (node.parent > 0 && words[node.parent - 1]) {
      return fail("line " + std::to_string(number) + ": its parent " + std::to_string(node.parent) + " is a word");
    }
    out.nodes.push_back(node);
    words.push_back(word == 1);
  }
  return out;
}

std::string write_vocabulary_text(const VocabularyText& text) {
  std::string out;
  put(out, text.branching, ' ');
  put(out, text.depth, ' ');
  out += "0 0\n";
  const std::vector<bool> parents = find_parents(text.nodes);
  for (size_t i = 0; i < text.nodes.size(); ++i) {
    const VocabularyNode& node = text.nodes[i];
    std::array<uint8_t, 32> bytes;
    std::memcpy(bytes.data(), node.descriptor.bits.data(), bytes.size());
    put(out, node.parent, ' ');
    out += parents[i + 1] ? "0 " : "1 ";
    for (const uint8_t byte : bytes) put(out, byte, ' ');
    put(out, node.weight, '\n');
  }
  return out;
}

}  // namespace covis
