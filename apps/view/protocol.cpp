// SPDX-License-Identifier: Apache-2.0
#include "apps/view/protocol.h"

#include <array>
#include <cstring>

namespace covis::view {
namespace {

constexpr size_t kHead = 2 * sizeof(uint32_t);

size_t filled(size_t size) { return (size + 3) / 4 * 4; }

struct LoopHead {
  uint32_t index = 0;
  int32_t frame = 0;
  LoopPaths::Kind kind = LoopPaths::Kind::closed;
  float correction = 0;
  uint32_t before = 0, after = 0;
};

}  // namespace

void BlockWriter::begin(Block kind, size_t size) {
  put(std::array<uint32_t, 2>{static_cast<uint32_t>(kind), static_cast<uint32_t>(size)});
}

void BlockWriter::fill() { bytes_.resize(filled(bytes_.size()), '\0'); }

void BlockWriter::text(Block kind, std::string_view text) {
  begin(kind, text.size());
  bytes_ += text;
  fill();
}

void BlockWriter::loop(uint32_t index, const LoopPaths& loop) {
  const LoopHead head{
      index,           static_cast<int32_t>(loop.frame),          loop.kind,
      loop.correction, static_cast<uint32_t>(loop.before.size()), static_cast<uint32_t>(loop.after.size())};
  begin(Block::loop, sizeof head + (loop.before.size() + loop.after.size()) * sizeof(PlaceRow));
  put(head);
  put(std::span<const PlaceRow>(loop.before));
  put(std::span<const PlaceRow>(loop.after));
}

void BlockWriter::observations(Block kind, uint32_t id, std::span<const ObservationRow> rows) {
  begin(kind, sizeof id + rows.size_bytes());
  put(id);
  put(rows);
}

void BlockWriter::image(const Picture& p) {
  const std::array<uint32_t, 5> head{static_cast<uint32_t>(p.frame), p.width, p.height,
                                     static_cast<uint32_t>(p.keypoints.size()), static_cast<uint32_t>(p.jpeg.size())};
  begin(Block::image, sizeof head + p.keypoints.size_bytes() + p.jpeg.size());
  put(head);
  put(p.keypoints);
  bytes_ += p.jpeg;
  fill();
}

void ReadBlock::copy_to(void* list) const {
  if (!body.empty()) std::memcpy(list, body.data(), body.size());
}

Result<LoopPaths> ReadBlock::loop() const {
  LoopHead head;
  if (body.size() < sizeof head) return fail("a loop's block is too short");
  std::memcpy(&head, body.data(), sizeof head);
  const size_t count = size_t{head.before} + head.after;
  if (body.size() != sizeof head + count * sizeof(PlaceRow)) return fail("a loop's block has a wrong size");
  LoopPaths loop{head.frame, head.kind, head.correction, {}, {}};
  const auto rows = ReadBlock{kind, body.substr(sizeof head)}.rows<PlaceRow>();
  loop.before.assign(rows->begin(), rows->begin() + head.before);
  loop.after.assign(rows->begin() + head.before, rows->end());
  return loop;
}

Result<std::vector<ObservationRow>> ReadBlock::observations(uint32_t& id) const {
  if (body.size() < sizeof id) return fail("a block of observations is too short");
  std::memcpy(&id, body.data(), sizeof id);
  return ReadBlock{kind, body.substr(sizeof id)}.rows<ObservationRow>();
}

Result<std::vector<ReadBlock>> read_blocks(std::string_view message) {
  std::vector<ReadBlock> blocks;
  while (!message.empty()) {
    std::array<uint32_t, 2> head{};
    if (message.size() < kHead) return fail("it is cut short");
    std::memcpy(head.data(), message.data(), kHead);
    if (filled(head[1]) > message.size() - kHead) return fail("it is cut short");
    blocks.push_back({static_cast<Block>(head[0]), message.substr(kHead, head[1])});
    message.remove_prefix(kHead + filled(head[1]));
  }
  return blocks;
}

}  // namespace covis::view
