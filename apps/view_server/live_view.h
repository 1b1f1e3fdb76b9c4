// SPDX-License-Identifier: Apache-2.0
// A run that is shown while it goes on. The tracking thread leaves its results in an inbox and never waits for the
// server's thread, which takes them from there, reads the map now and then, and encodes images. Without a client the
// map is not read, and images are copied for key frames alone.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "apps/run/run_observer.h"
#include "apps/view_server/image_store.h"
#include "apps/view_server/server.h"
#include "covis/core/time.h"

namespace covis::view {

class LiveView : public app::RunObserver, public ViewSource {
 public:
  // info: what the page is to know before any frame (JSON).
  explicit LiveView(std::string info);

  // The tracking thread's calls.
  void run_begins(const System& system) override;
  void frame_tracked(const app::FrameStats& stats, const io::Frame& frame, const FrameReport& report) override;
  void frame_skipped(const app::FrameStats& stats) override;
  void loops_changed(const std::vector<LoopPaths>& loops) override;
  // From here on the system is not used any more; `last`: the whole run.
  void run_ended(ViewState last);

  // The server's thread.
  const ViewState& refresh() override;
  void tidy() override;
  std::optional<std::string> key_frame_image(const KeyFrameRow& key_frame) override;

 private:
  // The results that the tracking thread left.
  struct Inbox {
    std::vector<std::pair<FrameRow, std::string>> frames;
    std::vector<LoopPaths> loops;
    std::vector<RawImage> key_frames;
    std::optional<RawImage> image;
    std::optional<ViewState> last;
  };
  // When the map was read, and how long that took.
  struct Reading {
    Stopwatch since;
    double wait_ms = 0;  // until the next one
    std::shared_ptr<const Snapshot> snapshot;
  };
  void take_inbox();
  void read_map();
  void encode(Inbox& inbox);
  // Empty where the image can't be encoded; the first time that is logged.
  std::string encoded(const RawImage& image, int width);

  std::mutex inbox_mutex_;
  Inbox inbox_;
  std::atomic<bool> image_wanted_{false};
  std::atomic<uint32_t> first_own_{0};  // id of the first key frame of this run
  std::mutex system_mutex_;             // held while the map is read
  const System* system_ = nullptr;

  // The server's thread alone uses these.
  ViewState state_;
  Reading reading_;
  Stopwatch since_image_;
  ImageStore images_;
  bool problem_logged_ = false;  // that an image can't be encoded
};

}  // namespace covis::view
