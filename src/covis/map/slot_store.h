// SPDX-License-Identifier: Apache-2.0
// Owns values in slots named by handles of slot and generation. Freed slots are used again, latest freed first; the value of an
// erased slot is really destroyed. References stay valid until the thing itself is erased (values do not move).
#pragma once

#include <cassert>
#include <cstdint>
#include <deque>
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
      slot = static_cast<uint32_t>(slots_.size());
      slots_.emplace_back();
    } else {
      slot = free_.back();
      free_.pop_back();
    }
    slots_[slot].value.emplace(std::move(value));
    ++size_;
    return {slot, slots_[slot].generation};
  }

  // False when stale.
  bool erase(Handle id) {
    if (!find(id)) return false;
    Slot& slot = slots_[id.slot];
    slot.value.reset();
    ++slot.generation;
    free_.push_back(id.slot);
    --size_;
    return true;
  }

  const T* find(Handle id) const {
    if (id.slot >= slots_.size()) return nullptr;
    const Slot& slot = slots_[id.slot];
    return slot.generation == id.generation && slot.value ? &*slot.value : nullptr;
  }
  T* find(Handle id) { return const_cast<T*>(std::as_const(*this).find(id)); }
  const T& at(Handle id) const {
    const T* value = find(id);
    assert(value && "stale handle");
    return *value;
  }
  T& at(Handle id) { return const_cast<T&>(std::as_const(*this).at(id)); }

  size_t size() const { return size_; }

  // visit(handle, value), by rising slot.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (uint32_t s = 0; s < slots_.size(); ++s) {
      if (slots_[s].value) visit(Handle{s, slots_[s].generation}, *slots_[s].value);
    }
  }

  // Everything goes; old handles stay stale.
  void clear() {
    for (uint32_t s = 0; s < slots_.size(); ++s) {
      if (slots_[s].value) erase(Handle{s, slots_[s].generation});
    }
  }

 private:
  struct Slot {
    std::optional<T> value;
    uint32_t generation = 0;
  };
  std::deque<Slot> slots_;
  std::vector<uint32_t> free_;
  size_t size_ = 0;
};

}  // namespace covis
