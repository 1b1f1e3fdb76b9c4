// SPDX-License-Identifier: Apache-2.0
// Colours of features and points, for people who look at the map: nothing of tracking or mapping reads them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "covis/features/features.h"
#include "covis/types.h"

namespace covis {

// One for each feature of a key frame.
using ColoursPtr = std::shared_ptr<const std::vector<Colour>>;

// Returns the colour at each feature's place in the image, whose size is that of the features' image. A place outside
// gets the nearest pixel's.
ColoursPtr colours_at(const Features& features, const ColourImage& image);

// Means of colours, for as many things as `size` says.
class MeanColours {
 public:
  explicit MeanColours(size_t size) : sums_(size) {}
  void add(size_t index, const Colour& colour);
  // kNoColour where none was added.
  Colour mean(size_t index) const;

 private:
  struct Sum {
    uint32_t red = 0, green = 0, blue = 0, count = 0;
  };
  std::vector<Sum> sums_;
};

}  // namespace covis
