// SPDX-License-Identifier: Apache-2.0
// The one lock (architecture.md, decision 3): no thread reaches the map but through a guard.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <shared_mutex>

#include "covis/map/map.h"

namespace covis {

class SharedMap {
 public:
  class ReadGuard {
   public:
    const Map* operator->() const { return map_; }
    const Map& operator*() const { return *map_; }

   private:
    friend class SharedMap;
    ReadGuard(const Map& map, std::shared_mutex& mutex) : lock_(mutex), map_(&map) {}
    std::shared_lock<std::shared_mutex> lock_;
    const Map* map_;
  };

  class WriteGuard {
   public:
    Map* operator->() const { return map_; }
    Map& operator*() const { return *map_; }

   private:
    friend class SharedMap;
    WriteGuard(Map& map, std::shared_mutex& mutex, std::atomic<uint64_t>& revision) : lock_(mutex), map_(&map) {
      ++revision;
    }
    std::unique_lock<std::shared_mutex> lock_;
    Map* map_;
  };

  SharedMap() = default;
  explicit SharedMap(const Pinhole& camera) { map_.set_camera(camera); }

  ReadGuard read() const { return {map_, mutex_}; }
  WriteGuard write() { return {map_, mutex_, revision_}; }
  // Rises with every write guard: what was read at one revision is what is there as long as it stays. Needs no guard.
  uint64_t revision() const { return revision_.load(); }

 private:
  mutable std::shared_mutex mutex_;
  std::atomic<uint64_t> revision_{0};
  Map map_;
};

}  // namespace covis
