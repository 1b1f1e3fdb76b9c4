// SPDX-License-Identifier: Apache-2.0
// The messages from the command to the viewer's page, and the file of a finished run, which is the same bytes. A
// message is a sequence of blocks: the block's kind and the bytes of its body (two 32-bit numbers), then the body,
// filled up with zeros to a multiple of four bytes. A list of rows may come in several blocks.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/view/rows.h"
#include "covis/core/error.h"

namespace covis::view {

enum class Block : uint32_t {
  info = 1,                // JSON (ViewState::info); frames, texts and loops begin anew
  key_frames,              // KeyFrameRow: added or changed
  key_frames_removed,      // ids
  points,                  // PointRow: added or changed
  points_removed,          // ids
  edges,                   // EdgeRow: added or changed
  edges_removed,           // pairs of ids
  path,                    // PathRow: added or changed
  path_removed,            // frames
  frames,                  // FrameRow: more of them
  texts,                   // JSON: a list, more of them
  loop,                    // index, frame, kind, correction (f32), counts of rows before and after; PlaceRow of both
  image,                   // frame, width, height, count of keypoints, bytes of the picture; KeypointRow; a JPEG
  key_frame_observations,  // id of the key frame; ObservationRow
  point_observations,      // id of the point; ObservationRow
  cameras,                 // CameraRow: all of them, in place of those before
};

class BlockWriter {
 public:
  // Rows; no block without any.
  template <class Row>
  void rows(Block kind, std::span<const Row> rows) {
    if (rows.empty()) return;
    begin(kind, rows.size_bytes());
    put(rows);
  }
  void text(Block kind, std::string_view text);
  void loop(uint32_t index, const LoopPaths& loop);
  void observations(Block kind, uint32_t id, std::span<const ObservationRow> rows);
  // The size is that of the full image, in whose pixels the keypoints are.
  struct Picture {
    int32_t frame = 0;
    uint32_t width = 0, height = 0;
    std::span<const KeypointRow> keypoints;
    std::string_view jpeg;
  };
  void image(const Picture& picture);

  bool empty() const { return bytes_.empty(); }
  std::string take() { return std::move(bytes_); }

 private:
  void begin(Block kind, size_t size);
  void fill();
  template <class Value>
  void put(std::span<const Value> values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  template <class Value>
  void put(const Value& value) {
    put(std::span<const Value>(&value, 1));
  }

  std::string bytes_;
};

// A block of a message; the body refers to the message's bytes.
struct ReadBlock {
  Block kind = Block::info;
  std::string_view body;

  // The rows of a block whose body is nothing else; an error when the size does not fit.
  template <class Row>
  Result<std::vector<Row>> rows() const {
    std::vector<Row> list(body.size() / sizeof(Row));
    if (list.size() * sizeof(Row) != body.size()) return fail("a block ends within a row");
    copy_to(list.data());
    return list;
  }
  Result<LoopPaths> loop() const;
  // id: receives the key frame's or the point's.
  Result<std::vector<ObservationRow>> observations(uint32_t& id) const;

 private:
  void copy_to(void* list) const;
};

// The blocks of a message; an error when it is cut short.
Result<std::vector<ReadBlock>> read_blocks(std::string_view message);

}  // namespace covis::view
