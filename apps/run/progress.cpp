// SPDX-License-Identifier: Apache-2.0
#include "apps/run/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace covis::app {

Progress::Progress(int64_t total) : shown_(total != kHidden && isatty(STDERR_FILENO)), total_(total) {}

Progress::~Progress() {
  if (shown_) std::fputs("\n", stderr);
}

void Progress::show(std::string_view state, size_t done, const System::MapSize& map, int64_t dropped) {
  if (!shown_ || (since_.ms() < 100 && static_cast<int64_t>(done) != total_ && state == state_)) return;
  since_.restart();
  state_ = state;
  const double rate = static_cast<double>(done) / std::max(all_.ms() / 1000, 1e-3);
  std::fprintf(stderr, "\r\033[Kframe %zu", done);
  if (total_ > 0) std::fprintf(stderr, "/%lld", static_cast<long long>(total_));
  std::fprintf(stderr, "  %.1f fps  %.*s  %zu key frames  %zu points", rate, static_cast<int>(state.size()),
               state.data(), map.key_frames, map.points);
  if (dropped > 0) std::fprintf(stderr, "  %lld dropped", static_cast<long long>(dropped));
  if (total_ > 0)
    std::fprintf(stderr, "  %.0f s left",
                 static_cast<double>(total_ - static_cast<int64_t>(done)) / std::max(rate, 1e-3));
  std::fflush(stderr);
}

}  // namespace covis::app
