// SPDX-License-Identifier: Apache-2.0
// An array that grows without end, as the record of every frame of a live camera: its newest elements stay in memory,
// older ones are in a temporary file (spill_file.h) and come back when they are asked for. Elements never move, and
// growing copies none.
#pragma once

#include <bit>
#include <cstddef>
#include <new>
#include <ranges>
#include <utility>
#include <vector>

#include "covis/core/spill_file.h"

namespace covis {

template <class T>
class SpilledArray {
 public:
  // No file is made as long as one block is enough.
  SpilledArray() = default;
  SpilledArray(SpilledArray&& other) noexcept
      : file_(std::move(other.file_)),
        blocks_(std::exchange(other.blocks_, {})),
        size_(std::exchange(other.size_, 0)) {}
  SpilledArray& operator=(SpilledArray&&) = delete;
  ~SpilledArray() {
    shrink(0);
    for (const SpillFile::Block& block : blocks_) SpillFile::unmap(block);
  }

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T& operator[](size_t k) { return *at(k); }
  const T& operator[](size_t k) const { return *at(k); }
  T& back() { return *at(size_ - 1); }
  const T& back() const { return *at(size_ - 1); }
  // All elements, for loops and algorithms on ranges. page_out() afterwards lets the older ones go again.
  auto all() {
    return std::views::iota(size_t{0}, size_) | std::views::transform([this](size_t k) -> T& { return *at(k); });
  }
  auto all() const {
    return std::views::iota(size_t{0}, size_) | std::views::transform([this](size_t k) -> const T& { return *at(k); });
  }

  void push_back(T element) {
    if (size_ == blocks_.size() * kPerBlock) add_block();
    if (size_ % kPerBlock == 0 && size_ >= 2 * kPerBlock) SpillFile::page_out(blocks_[size_ / kPerBlock - 2]);
    ::new (at(size_)) T(std::move(element));
    ++size_;
  }
  // Makes room for a block of elements beyond the last one when there is less than half of it: push_back() does not
  // allocate as long as this is called now and then.
  void make_room() {
    if (blocks_.size() * kPerBlock - size_ < kPerBlock / 2) add_block();
  }
  // The first `count` elements go; the others move to the front.
  void erase_front(size_t count) {
    for (size_t k = count; k < size_; ++k) *at(k - count) = std::move(*at(k));
    shrink(size_ - count);
  }
  void page_out() const {
    for (size_t k = 0; (k + 2) * kPerBlock <= size_; ++k) SpillFile::page_out(blocks_[k]);
  }

  static constexpr size_t kPerBlock = std::bit_floor((size_t{1} << 20) / sizeof(T));

 private:
  T* at(size_t k) const { return static_cast<T*>(blocks_[k / kPerBlock].memory) + k % kPerBlock; }
  void add_block() {
    constexpr size_t kPage = 4096, kBytes = (kPerBlock * sizeof(T) + kPage - 1) / kPage * kPage;
    blocks_.reserve(blocks_.size() + 1);  // so that no block is lost for want of memory
    blocks_.push_back(blocks_.empty() ? SpillFile::plain(kBytes) : file_.map(kBytes));
  }
  void shrink(size_t size) {
    while (size_ > size) at(--size_)->~T();
  }

  SpillFile file_;
  std::vector<SpillFile::Block> blocks_;
  size_t size_ = 0;
};

}  // namespace covis
