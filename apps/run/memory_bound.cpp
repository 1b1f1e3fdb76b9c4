// SPDX-License-Identifier: Apache-2.0
#include "apps/run/memory_bound.h"

#include <string>

#ifdef __GLIBC__  // defined by the headers above
#include <malloc.h>
#endif

namespace covis::app {

Result<int> map_megabytes(int megabytes, const Camera& camera, uint64_t vocabulary_bytes) {
  constexpr double kProgram = 110;       // MB, of which libraries take two thirds
  constexpr double kBytesAPixel = 40;    // bytes of two images: decoded ahead, in pyramids, blurred
  constexpr double kBesideTheMap = 3.2;  // memory of a map that is adjusted and saved, by its own size
  constexpr double kLeastMap = 20;       // MB: the newest 50 key frames, which are not thinned, and some more
  const double read = kBytesAPixel * camera.width * camera.height + static_cast<double>(vocabulary_bytes);
  const double fixed = kProgram + read / 1e6;
  const double map = (megabytes - fixed) / kBesideTheMap;
  if (map < kLeastMap) {
    return fail("--max-memory " + std::to_string(megabytes) + ": images of this size need at least " +
                std::to_string(static_cast<int>(fixed + kLeastMap * kBesideTheMap) + 1) + " MB");
  }
  return static_cast<int>(map);
}

void return_memory_at_once() {
#ifdef __GLIBC__
  constexpr int kPage = 4096;         // bytes
  constexpr int kMostChunks = 30000;  // Linux allows a process 65530 mappings
  mallopt(M_MMAP_THRESHOLD, kPage);
  mallopt(M_MMAP_MAX, kMostChunks);
#endif
}

}  // namespace covis::app
