// SPDX-License-Identifier: Apache-2.0
// Keypoints and descriptors of one image. Keeps its pyramid until the next call: stereo matching reads it.
#pragma once

#include <memory>
#include <vector>

#include "covis/features/fast.h"
#include "covis/features/frontend.h"
#include "covis/features/pyramid.h"
#include "covis/features/quadtree.h"

namespace covis {

// Keypoints in the image's own pixels, level 0 scale.
struct KeyPoints {
  AlignedVector<float> x, y, angle;
  AlignedVector<uint8_t> level;
  AlignedVector<Descriptor> descriptor;
  void clear();
  void reserve(size_t n);
  void append(const KeyPoints& more);
  size_t size() const { return x.size(); }
};

class OrbExtractor {
 public:
  explicit OrbExtractor(const OrbOptions& options);

  // No image gives more: each level may go beyond its share by three.
  size_t most_keypoints() const { return static_cast<size_t>(options_.features + 3 * options_.levels); }
  void set_budget(int features) { options_.features = features; }
  // Sorted by level, then row, then column.
  const KeyPoints& extract(ImageView<const uint8_t> image);

  // The same in steps, one after the other; detect() and describe() of different levels may run in different threads.
  void start(ImageView<const uint8_t> image);  // the pyramid
  void detect(int level);                      // corners
  void share_budget();                         // keypoints wanted of each level
  void describe(int level);                    // keypoints and descriptors
  const KeyPoints& finish();                   // keypoints of all levels

  const KeyPoints& keypoints() const { return keypoints_; }
  int levels() const { return static_cast<int>(levels_.size()); }
  // Level of the last image; level 0 is the caller's.
  ImageView<const uint8_t> level(int l) const { return levels_[static_cast<size_t>(l)].view; }
  // Pixels of a level to pixels of the image, and back. Pixel centres are at whole numbers and a level's pixels tile
  // the same area, so its centre (0, 0) lies half a pixel of the level inside the corner: leaving that out shifts the
  // keypoints of the coarsest level by more than a pixel.
  Eigen::Vector2f to_image(int l, float x, float y) const {
    const Eigen::Vector2f& s = levels_[static_cast<size_t>(l)].stretch;
    return {(x + 0.5f) * s.x() - 0.5f, (y + 0.5f) * s.y() - 0.5f};
  }
  Eigen::Vector2f to_level(int l, float x, float y) const {
    const Eigen::Vector2f& s = levels_[static_cast<size_t>(l)].stretch;
    return {(x + 0.5f) / s.x() - 0.5f, (y + 0.5f) / s.y() - 0.5f};
  }
  float stretch(int l) const { return levels_[static_cast<size_t>(l)].stretch.x(); }  // image columns a level's pixel
  const std::shared_ptr<const ScalePyramid>& pyramid() const { return pyramid_; }

 private:
  // With scratch memory of its own: levels are worked on side by side.
  struct Level {
    ImageU8 image;  // empty in level 0
    ImageView<const uint8_t> view;
    Eigen::Vector2f stretch;  // image pixels a pixel
    BilinearResizer resizer;
    FastDetector detector;
    std::vector<Corner> corners, kept;
    Quadtree quadtree;
    GaussianBlur blur;
    ImageU8 blurred;
    KeyPoints keypoints;
  };

  OrbOptions options_;
  std::shared_ptr<const ScalePyramid> pyramid_;
  std::vector<Level> levels_;
  std::vector<int> available_, share_;  // corners found and wanted, for each level
  KeyPoints keypoints_;
};

}  // namespace covis
