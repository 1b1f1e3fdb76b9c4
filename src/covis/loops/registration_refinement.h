// SPDX-License-Identifier: Apache-2.0
// The registration of depth images to images, found while the map is small: when the map is asked for it, and how the
// map gets the depths of another one. Measured figures: docs/notes/052-depth-that-is-not-registered.md.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "covis/loops/background_adjustment.h"
#include "covis/loops/registration_search.h"
#include "covis/mapping/map_problem.h"

namespace covis {

// The map is asked a few times, until it answers. Key frames keep their depth images until it was asked for the last
// time.
class RegistrationSchedule {
 public:
  // True when the map is to be asked now.
  bool ask(const Map& map);
  // The key frames to come keep their depth images.
  static bool keeps_depths(const Map& map) { return map.next_serial() < kLast; }
  // Takes them from all key frames, once the map is not asked any more.
  static void drop_depths(SharedMap& map);

 private:
  static constexpr uint32_t kFirst = 8, kLast = 32;  // serials of key frames

  uint32_t next_ = kFirst;
};

// Figures that depth gave when it was looked up in wrong places, and that are to be found anew.
struct LearnedOfDepth {
  double given_fx = 0;  // the focal length that the camera came with, pixels
  bool noise = true;    // the noise of depths is estimated
};

// Bundle adjustment of a submap whose depths are looked up by the registration that the images tell, when that is
// clearly another one than the camera's. Its result is applied to a map of one submap alone.
class RegistrationRefinement : public AdjustmentJob {
 public:
  // Null when there is nothing to adjust.
  static std::unique_ptr<RegistrationRefinement> of(const Map& map, KeyFrameId key_frame,
                                                    const LearnedOfDepth& learned);

  AdjustmentKind kind() const override { return AdjustmentKind::camera; }
  bool run(const std::atomic<bool>& interrupt) override;
  std::optional<KeyFrameMoves> apply(SharedMap& map) const override;

 private:
  RegistrationRefinement(MapProblem submap, const LearnedOfDepth& learned)
      : submap_(std::move(submap)), learned_(learned) {}
  std::vector<DepthSight> sights(const BundleProblem& problem, const std::atomic<bool>& interrupt) const;
  std::optional<BundleProblem> without_depth(const std::atomic<bool>& interrupt) const;
  bool adjust(const std::atomic<bool>& interrupt);

  MapProblem submap_;
  const LearnedOfDepth learned_;
  std::vector<FeaturesPtr> features_;  // those of key frames
  std::vector<uint32_t> feature_;      // one for each observation
};

}  // namespace covis
