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

  // No image gives more: each level may go beyond its share by three.
  size_t most_key_points() const { return static_cast<size_t>(options_.features + 3 * options_.levels); }
  void set_budget(int features) { options_.features = features; }
  // Sorted by level, then row, then column.
  const KeyPoints& extract(ImageView<const uint8_t> image);
  const KeyPoints& key_points() const { return key_points_; }
  // Level of the last image; level 0 is the caller's.
  ImageView<const uint8_t> level(int l) const { return l == 0 ? image_ : levels_[static_cast<size_t>(l)].view(); }
  // Pixels of a level to pixels of the image, and back. Pixel centres are at whole numbers and a level's pixels tile the
  // same area, so its centre (0, 0) lies half a pixel of the level inside the corner: leaving that out shifts the key
  // points of the coarsest level by more than a pixel.
  Eigen::Vector2f to_image(int l, float x, float y) const {
    const Eigen::Vector2f& s = stretch_[static_cast<size_t>(l)];
    return {(x + 0.5f) * s.x() - 0.5f, (y + 0.5f) * s.y() - 0.5f};
  }
  Eigen::Vector2f to_level(int l, float x, float y) const {
    const Eigen::Vector2f& s = stretch_[static_cast<size_t>(l)];
    return {(x + 0.5f) / s.x() - 0.5f, (y + 0.5f) / s.y() - 0.5f};
  }
  float stretch(int l) const { return stretch_[static_cast<size_t>(l)].x(); }  // image columns a level's pixel
  const std::shared_ptr<const ScalePyramid>& pyramid() const { return pyramid_; }

 private:
  OrbOptions options_;
  std::shared_ptr<const ScalePyramid> pyramid_;
  ImageView<const uint8_t> image_;
  std::vector<ImageU8> levels_;  // [0] unused
  std::vector<Eigen::Vector2f> stretch_;  // image pixels a level's pixel, for each level
  std::vector<BilinearResizer> resizers_;
  std::vector<int> available_, share_;  // corners found and wanted, for each level
  std::vector<std::vector<Corner>> corners_, kept_;
  ImageU8 blurred_;
  GaussianBlur blur_;
  FastDetector detector_;
  Quadtree quadtree_;
  KeyPoints key_points_;
};

}  // namespace covis
