// SPDX-License-Identifier: Apache-2.0
// Adjustments of a whole submap on a thread of their own, on a copy, beside mapping. The mapping thread starts a job,
// applies its result some key frames later, or gives it up when a loop comes.
// Source: Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, section III-D.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <thread>

#include "covis/map/key_frame_moves.h"
#include "covis/map/shared_map.h"

namespace covis {

enum class AdjustmentKind { full, camera };

// A copy of what is to be adjusted, made under a read guard of the map.
class AdjustmentJob {
 public:
  virtual ~AdjustmentJob() = default;
  virtual AdjustmentKind kind() const = 0;
  // On the job's thread, without the map; ends soon when `interrupt` becomes true. False: there is no result to apply.
  virtual bool run(const std::atomic<bool>& interrupt) = 0;
  // On the mapping thread, without a guard: reads what it needs, then writes. Nothing: the map has changed so that the
  // result does not fit, and was left alone.
  virtual std::optional<KeyFrameMoves> apply(SharedMap& map) const = 0;
};

class BackgroundAdjustment {
 public:
  ~BackgroundAdjustment() { abandon(); }

  // Gives up the job there is and begins this one (null: none), whose result is due after so many key frames. Where no
  // thread can be started there is none.
  void start(std::unique_ptr<AdjustmentJob> job, int key_frames);
  bool running() const { return job_ != nullptr; }  // or its result waits
  // Another key frame was mapped.
  void count_key_frame() { --key_frames_left_; }
  // The result may be applied, for a schedule that does not depend on time.
  bool due() const { return key_frames_left_ <= 0; }
  // The result is there: apply() will not wait.
  bool ready() const { return done_.load(); }

  struct Outcome {
    AdjustmentKind kind = AdjustmentKind::full;
    bool solved = false;       // there was a result
    bool applied = false;      // the map was changed
    double ms = 0;             // that the job ran
    KeyFrameMoves moves = {};  // poses relative to key frames are to follow
  };
  // Waits for the result and writes it to the map. Only while running().
  Outcome apply(SharedMap& map);
  // Interrupts and forgets the job.
  void abandon();

 private:
  void run() noexcept;  // on the thread

  std::unique_ptr<AdjustmentJob> job_;  // the thread's until that is joined
  int key_frames_left_ = 0;
  bool solved_ = false;
  double ms_ = 0;
  std::atomic<bool> interrupt_{false}, done_{false};
  std::thread thread_;
};

}  // namespace covis
