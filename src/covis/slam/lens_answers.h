// SPDX-License-Identifier: Apache-2.0
// The maps of one recording, each tracked with another lens, tell of its lens. Each map is adjusted by models with
// fewer and more free parameters (lens_adjustment.h). Parameters that nothing shows would cost the focal length its
// precision, as a narrow view hardly tells them apart from it: the simplest model is believed that leaves out nothing
// which shows, that is which differs from its usual value by three standard deviations.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "covis/optimization/lens_adjustment.h"

namespace covis {

// The focal length is free in all of them; in the second also k1, in the third k2, in the last the principal point.
inline constexpr size_t kLensModels = 4;

// The lens that one map shows.
struct LensAnswer {
  double given = 0;  // focal length that it was tracked with, pixels
  std::array<LensAdjustment, kLensModels> found;
  size_t key_frames = 0;
  int64_t tracked = 0;  // number of frames
};

inline constexpr double kLeastFocal = 0.25, kGreatestFocal = 4;  // over the longer side of the image: 127, 14 degrees

// Adjusts the problem by each model, beginning with the lens `given` it was tracked with. `longer_side`: of the image,
// pixels. A model without a result, or with one that no lens has, is not ok; `interrupt` ends all of them.
LensAnswer answer_of(BundleProblem& problem, const Lens& given, double longer_side,
                     const std::atomic<int>* interrupt = nullptr);

// For observations that err more alike than the adjustment can tell.
void scale_deviations(LensAnswer& answer, double factor);

// The adjustment to believe of one answer; nullptr where none is ok.
const LensAdjustment* believed(const LensAnswer& answer);

// The lens that a recording gives back when it is tracked with it.
struct SettledLens {
  Lens lens;
  Lens sigma;         // standard deviations; also of what was left out, and what that would change of the focal length
  double change = 1;  // how far the focal length's logarithm is from where it was looked for
  double fall = 0;    // share of a focal length's error that a map takes away
  bool repeats = true;  // the maps keep nearly the whole error of the focal length they were given, so tell nothing
};

// A map remembers the focal length that it was tracked with: a part of an error can stay. So the focal length that
// would give itself is found on the line through the answers whose given one is near that of `lens`. nullopt where
// these have no model in common. `longer_side`: of the image, pixels. `fall`: that of answers that were farther apart,
// where these are too near one another to show it.
std::optional<SettledLens> settle(std::span<const LensAnswer> answers, const Lens& lens, double longer_side,
                                  std::optional<double> fall = std::nullopt);

}  // namespace covis
