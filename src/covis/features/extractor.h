// SPDX-License-Identifier: Apache-2.0
// Key points and descriptors of one image. Keeps its pyramid until the next call: stereo matching reads it.
#pragma once

#include <memory>
#include <vector>

#include "covis/features/fast.h"
#include "covis/features/frontend.h"
#include "covis/features/pyramid.h"
#include "covis/features/quadtree.h"

namespace covis {

// Key points in the image's own pixels, level 0 scale.
struct KeyPoints {
  AlignedVector<float> x, y, angle;
  AlignedVector<uint8_t> level;
  AlignedVector<Descriptor> descriptor;
  void clear();
  size_t size() const { return x.size(); }
};

class OrbExtractor {
 public:
  explicit OrbExtractor(const OrbOptions& options);

  void set_budget(int features) { options_.features = features; }
  // Sorted by level, then row, then column.
  const KeyPoints& extract(ImageView<const uint8_t> image);
  const KeyPoints& key_points() const { return key_points_; }
  // Level of the last image; level 0 is the caller's.
  ImageView<const uint8_t> level(int l) const { return l == 0 ? image_ : levels_[static_cast<size_t>(l)].view(); }
  const std::shared_ptr<const ScalePyramid>& pyramid() const { return pyramid_; }

 private:
  OrbOptions options_;
  std::shared_ptr<const ScalePyramid> pyramid_;
  ImageView<const uint8_t> image_;
  std::vector<ImageU8> levels_;  // [0] unused
  std::vector<BilinearResizer> resizers_;
  std::vector<std::vector<Corner>> corners_, kept_;
  ImageU8 blurred_;
  GaussianBlur blur_;
  FastDetector detector_;
  Quadtree quadtree_;
  KeyPoints key_points_;
};

}  // namespace covis
