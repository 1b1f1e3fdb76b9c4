// SPDX-License-Identifier: Apache-2.0
// A good recording with a fault in it, through the public interface, and what came of it.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "synth/synth.h"
#include "tests/faults/faults.h"

namespace covis::faults {

// A recording without faults, whose frames are in memory once they were asked for.
class GoodRecording {
 public:
  virtual ~GoodRecording() = default;
  virtual Sensor sensor() const = 0;
  virtual Camera camera() const = 0;
  virtual int size() const = 0;
  virtual const Moment& operator()(int i) = 0;                       // the first or last one for a number beyond
  virtual std::optional<Eigen::Vector3d> position(int i) const = 0;  // true, of the camera in the world, metres
};

// Frames of a world, each rendered once.
class RenderedRecording : public GoodRecording {
 public:
  // `turn`: the last frame before the camera goes back the way it came, if it does.
  RenderedRecording(const SynthOptions& options, int frames, std::optional<int> turn = {});
  Sensor sensor() const override { return synth_.sensor(); }
  Camera camera() const override { return synth_.camera(); }
  int size() const override { return static_cast<int>(frames_.size()); }
  const Moment& operator()(int i) override;
  std::optional<Eigen::Vector3d> position(int i) const override { return synth_.T_wc(place(i)).t(); }

 private:
  int place(int i) const { return turn_ && i > *turn_ ? std::max(0, 2 * *turn_ - i) : i; }

  Synth synth_;
  std::optional<int> turn_;
  std::vector<Moment> frames_;
};

// The frames that a fault is at: from `first` up to but without `end`.
struct Stretch {
  int first = 0, end = 0;
  bool has(int i) const { return i >= first && i < end; }
};

struct FaultResult {
  int sure_outside = 0, sure_within = 0;    // frames outside and within the stretch that are tracked and not tentative
  int outside = 0, within = 0;              // frames that came
  int refused = 0;                          // frames that were refused with a message
  int wrong_outside = 0, wrong_within = 0;  // sure frames that are far from the truth
  int found_after = -1;                     // frames from the end of the stretch to one with a right pose that it kept,
                                            // tentative or not; -1: never
  int sure_after = -1;                      // the same to a sure one, right or wrong
  int recovered_after = -1;                 // the same to a sure one in the first submap
  int warned_after = -1;                    // frames from the start of the stretch to a warning; -1: none
  double median_error = 0;                  // metres, of sure frames
  double greatest_error = 0;                // metres, of sure frames
};

// `usual_error`: metres by which frames may be off anyway, as without the fault. What the fault adds is independent of
// it: a frame is wrong beyond the root of the sum of both squares.
FaultResult run_fault(GoodRecording& recording, const Fault& fault, Stretch stretch, double usual_error = 0);

}  // namespace covis::faults
