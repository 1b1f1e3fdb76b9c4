// SPDX-License-Identifier: Apache-2.0
// Owns values in slots named by handles of slot and generation. Freed slots are used again, latest freed first; the
// value of an erased slot is really destroyed. References stay valid until the thing itself is erased (values do not
// move).
#pragma once

#include <array>
#include <cassert>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace covis {

template <class Handle, class T>
class SlotStore {
 public:
  Handle insert(T value) {
    uint32_t slot;
    if (free_.empty()) {
      slot = slots_;
      if (slot / kBlock == blocks_.size()) blocks_.push_back(std::make_unique<Block>());
      ++slots_;  // after what can throw: each slot counted has its block
    } else {
      slot = free_.back();
      free_.pop_back();
    }
    Slot& made = at_slot(slot);
    made.value.emplace(std::move(value));
    ++size_;
    return {slot, made.generation};
  }

  // False when stale.
  bool erase(Handle id) {
    if (!find(id)) return false;
    free_.push_back(id.slot);  // first, as it can throw
    Slot& slot = at_slot(id.slot);
    slot.value.reset();
    ++slot.generation;
    --size_;
    return true;
  }

  const T* find(Handle id) const {
    if (id.slot >= slots_) return nullptr;
    const Slot& slot = at_slot(id.slot);
    return slot.generation == id.generation && slot.value ? &*slot.value : nullptr;
  }
  T* find(Handle id) { return const_cast<T*>(std::as_const(*this).find(id)); }
  const T& at(Handle id) const {
    const T* value = find(id);
    assert(value && "stale handle");
    return *value;
  }
  T& at(Handle id) { return const_cast<T&>(std::as_const(*this).at(id)); }

  // The handle of the value in this slot; invalid when it is empty.
  Handle handle(uint32_t slot) const {
    return slot < slots_ && at_slot(slot).value ? Handle{slot, at_slot(slot).generation} : Handle{};
  }

  size_t size() const { return size_; }

  // visit(handle, value), by rising slot.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (uint32_t s = 0; s < slots_; ++s) {
      if (const Slot& slot = at_slot(s); slot.value) visit(Handle{s, slot.generation}, *slot.value);
    }
  }

 private:
  struct Slot {
    std::optional<T> value;
    uint32_t generation = 0;
  };
  // This size wastes little: a deque would have three map points to a piece of its own.
  static constexpr uint32_t kBlock = 32;
  using Block = std::array<Slot, kBlock>;

  const Slot& at_slot(uint32_t slot) const { return (*blocks_[slot / kBlock])[slot % kBlock]; }
  Slot& at_slot(uint32_t slot) { return (*blocks_[slot / kBlock])[slot % kBlock]; }

  std::vector<std::unique_ptr<Block>> blocks_;
  std::vector<uint32_t> free_;
  uint32_t slots_ = 0;  // ever used
  size_t size_ = 0;
};

}  // namespace covis
