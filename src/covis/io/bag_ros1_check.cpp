// SPDX-License-Identifier: Apache-2.0
#include "covis/io/bag_ros1_check.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <deque>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace covis::io {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr uint32_t kLargestChunk = uint32_t{1} << 30;  // bytes
// Bytes of a chunk that is compressed: nothing in the file bounds what it announces. Recorders begin a new one after
// 768 kB, so that it holds a single message when it is larger.
constexpr uint32_t kLargestCompressed = 128'000'000;
constexpr int kMostConnections = 16;  // one behind another before a message; recorders write one

// The kinds of records, by their field "op".
enum Operation : uint8_t { kMessage = 2, kFileHeader = 3, kIndex = 4, kChunk = 5, kChunkInfo = 6, kConnection = 7 };

std::optional<uint32_t> word_at(std::string_view bytes, size_t at) {
  uint32_t word = 0;
  if (bytes.size() < sizeof word || at > bytes.size() - sizeof word) return std::nullopt;
  std::memcpy(&word, bytes.data() + at, sizeof word);
  return word;
}

// A header of fields "name=value", each behind its length, and data.
struct BagRecord {
  std::string_view header, data;

  size_t size() const { return 2 * sizeof(uint32_t) + header.size() + data.size(); }
  // Empty: there is no such field, or the header is damaged before it.
  std::string_view field(std::string_view name) const {
    size_t at = 0;
    for (auto length = word_at(header, at); length; length = word_at(header, at)) {
      at += sizeof(uint32_t);
      if (*length > header.size() - at) return {};
      const std::string_view text = header.substr(at, *length);
      if (text.size() > name.size() && text.starts_with(name) && text[name.size()] == '=')
        return text.substr(name.size() + 1);
      at += *length;
    }
    return {};
  }
  int operation() const {
    const std::string_view op = field("op");
    return op.size() == 1 ? op[0] : -1;
  }
  // A little-endian number; nullopt when the field is missing or of another size.
  template <class T>
  std::optional<T> number(std::string_view name) const {
    const std::string_view value = field(name);
    T number{};
    if (value.size() != sizeof number) return std::nullopt;
    std::memcpy(&number, value.data(), sizeof number);
    return number;
  }
};

// True when a header holds fields "name=value" and nothing else.
bool fields_are_whole(std::string_view header) {
  while (!header.empty()) {
    const auto length = word_at(header, 0);
    if (!length || *length > header.size() - sizeof(uint32_t)) return false;
    if (header.substr(sizeof(uint32_t), *length).find('=') == std::string_view::npos) return false;
    header.remove_prefix(sizeof(uint32_t) + *length);
  }
  return true;
}

std::optional<BagRecord> record_at(std::string_view bytes, size_t at) {
  const auto header = word_at(bytes, at);
  if (!header || *header > bytes.size() - at - sizeof(uint32_t)) return std::nullopt;
  const size_t data_at = at + sizeof(uint32_t) + *header;
  const auto data = word_at(bytes, data_at);
  if (!data || *data > bytes.size() - data_at - sizeof(uint32_t)) return std::nullopt;
  const BagRecord record{bytes.substr(at + sizeof(uint32_t), *header), bytes.substr(data_at + sizeof(uint32_t), *data)};
  if (!fields_are_whole(record.header)) return std::nullopt;
  // A connection's data are fields, too.
  if (record.operation() == kConnection && !fields_are_whole(record.data)) return std::nullopt;
  return record;
}

struct BagChunk {
  bool compressed = false;
  uint32_t size = 0;             // bytes, not compressed
  std::vector<uint32_t> places;  // its messages and the connections right before them, ascending; none if compressed
};

// Lists the places that lead to messages, as far as whole records go.
std::vector<uint32_t> places_of_messages(std::string_view chunk) {
  std::vector<uint32_t> places;
  std::deque<size_t> connections;  // the last ones before the present place
  for (size_t at = 0; at < chunk.size();) {
    const auto record = record_at(chunk, at);
    if (!record) break;
    connections.push_back(at);
    if (record->operation() == kMessage) places.insert(places.end(), connections.begin(), connections.end());
    if (record->operation() != kConnection) connections.clear();
    if (connections.size() > kMostConnections) connections.pop_front();
    at += record->size();
  }
  return places;
}

Result<BagChunk> chunk_of(const BagRecord& record) {
  constexpr uint32_t kMegabyte = 1'000'000;
  const auto size = record.number<uint32_t>("size");
  const bool compressed = record.field("compression") != "none";
  if (!size || *size > kLargestChunk || (!compressed && record.data.size() != *size))
    return fail("a chunk of messages is damaged");
  if (compressed && *size > kLargestCompressed) {
    return fail("a compressed chunk of messages announces " + std::to_string((*size + kMegabyte - 1) / kMegabyte) +
                " MB, and " + std::to_string(kLargestCompressed / kMegabyte) +
                " can be read; `rosbag decompress` makes a bag that can be read. That chunk is");
  }
  if (compressed) return BagChunk{true, *size, {}};
  return BagChunk{false, *size, places_of_messages(record.data)};
}

// True when an index of messages in the chunk leads to messages.
bool leads_to_messages(const BagRecord& index, const BagChunk& chunk) {
  constexpr size_t kEntry = 12;  // bytes: a time, and the place in the chunk
  const auto count = index.number<uint32_t>("count");
  if (!count || index.data.size() != *count * kEntry) return false;
  for (size_t at = 8; at < index.data.size(); at += kEntry) {
    const uint32_t place = *word_at(index.data, at);
    if (place >= chunk.size) return false;
    if (!chunk.compressed && !std::binary_search(chunk.places.begin(), chunk.places.end(), place)) return false;
  }
  return true;
}

}  // namespace

Result<void> check_ros1_records(std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) return {};
  std::set<uint64_t> chunks;       // their places
  std::optional<BagChunk> latest;  // the chunk whose indices follow
  uint64_t index_at = 0;
  std::pair<uint64_t, uint64_t> announced, found;  // connections and chunks in the index
  for (size_t at = kMagic.size(); at < bytes.size();) {
    const auto damaged = [&](const std::string& problem) {
      return fail(problem + " at byte " + std::to_string(at) + " of " + std::to_string(bytes.size()));
    };
    const auto record = record_at(bytes, at);
    if (!record) return damaged("a record is cut short or damaged");
    switch (record->operation()) {
      case kFileHeader:
        index_at = record->number<uint64_t>("index_pos").value_or(0);
        if (index_at == 0) return {};  // it has no index, and rosbag_storage says so
        announced = {record->number<uint32_t>("conn_count").value_or(0),
                     record->number<uint32_t>("chunk_count").value_or(0)};
        break;
      case kChunk: {
        auto chunk = chunk_of(*record);
        if (!chunk) return damaged(chunk.error().message);
        latest = std::move(*chunk);
        chunks.insert(at);
        break;
      }
      case kIndex:
        if (!latest || !leads_to_messages(*record, *latest)) return damaged("an index of messages is damaged");
        break;
      case kChunkInfo: {
        const auto place = record->number<uint64_t>("chunk_pos");
        const auto count = record->number<uint32_t>("count");
        if (!place || !chunks.contains(*place) || !count || record->data.size() != *count * uint64_t{8})
          return damaged("the index is damaged");
        found.second += at >= index_at;
        break;
      }
      case kConnection:
        found.first += at >= index_at;
        break;
      default:
        return damaged("an unknown record is");
    }
    at += record->size();
  }
  if (found != announced) return fail("its index is not where its beginning says, or is cut short");
  return {};
}

}  // namespace covis::io
