// SPDX-License-Identifier: Apache-2.0
// Keypoints and descriptors of one image. The pyramid is kept until the next call, because stereo matching reads it.
#pragma once

#include <memory>
#include <vector>

#include "covis/features/fast.h"
#include "covis/features/frontend.h"
#include "covis/features/pyramid.h"
#include "covis/features/quadtree.h"

namespace covis {

// Returns keypoints in the image's own pixels, at the scale of level 0.
struct KeyPoints {
  AlignedVector<float> x, y, angle;
  AlignedVector<uint8_t> level;
  AlignedVector<Descriptor> descriptor;
  void clear();
  void reserve(size_t n);
  void append(const KeyPoints& more);
  size_t size() const { return x.size(); }
};

// How many keypoints an image of this size, pixels, has room for on all levels together: more of them would show much
// the same patches.
int keypoint_room(const OrbOptions& options, int width, int height);

class OrbExtractor {
 public:
  // options.levels: 0 stands for 8. edge_ratio: corners on edges (gradients.h) are left out; 0: none are.
  explicit OrbExtractor(const OrbOptions& options, double edge_ratio = 0);

  // Upper bound on the keypoints of an image: each level may exceed its share by three.
  size_t most_keypoints() const { return static_cast<size_t>(budget_ + 3 * levels()); }
  // Wants so many keypoints from now on, instead of OrbOptions::features.
  void set_budget(int features) { budget_ = features; }
  // Keypoints are sorted by level, then row, then column.
  const KeyPoints& extract(ImageView<const uint8_t> image);

  // The same in steps, to be called in this order; detect() and describe() of different levels may run in parallel.
  void start(ImageView<const uint8_t> image);  // builds the pyramid
  void detect(int level);                      // finds the corners of a level
  void share_budget();                         // sets the number of keypoints wanted on each level
  void describe(int level);                    // computes the level's keypoints and descriptors
  const KeyPoints& finish();                   // joins the keypoints of all levels

  const KeyPoints& keypoints() const { return keypoints_; }
  int levels() const { return static_cast<int>(levels_.size()); }
  // Returns a level of the last image's pyramid; level 0 is the caller's image.
  ImageView<const uint8_t> level(int l) const { return levels_[static_cast<size_t>(l)].view; }
  // The same, blurred as descriptors are made of it; empty where the level has no keypoint.
  ImageView<const uint8_t> blurred(int l) const {
    const Level& level = levels_[static_cast<size_t>(l)];
    return level.kept.empty() ? ImageView<const uint8_t>() : level.blurred.view();
  }
  // Conversion between pixels of a level and pixels of the image. Pixel centres lie at integer coordinates and a
  // level's pixels tile the same area, so its centre (0, 0) lies half a pixel of the level inside the corner. Ignoring
  // that would shift the keypoints of the coarsest level by more than a pixel.
  Eigen::Vector2f to_image(int l, float x, float y) const {
    const Eigen::Vector2f& s = levels_[static_cast<size_t>(l)].stretch;
    return {(x + 0.5f) * s.x() - 0.5f, (y + 0.5f) * s.y() - 0.5f};
  }
  Eigen::Vector2f to_level(int l, float x, float y) const {
    const Eigen::Vector2f& s = levels_[static_cast<size_t>(l)].stretch;
    return {(x + 0.5f) / s.x() - 0.5f, (y + 0.5f) / s.y() - 0.5f};
  }
  float stretch(int l) const { return levels_[static_cast<size_t>(l)].stretch.x(); }  // image columns per level pixel
  const std::shared_ptr<const ScalePyramid>& pyramid() const { return pyramid_; }

 private:
  // One pyramid level, with its own scratch memory because levels are processed in parallel.
  struct Level {
    ImageU8 image;  // empty in level 0
    ImageView<const uint8_t> view;
    Eigen::Vector2f stretch;  // image pixels per level pixel
    BilinearResizer resizer;
    FastDetector detector;
    std::vector<Corner> corners, kept;
    Quadtree quadtree;
    GaussianBlur blur;
    ImageU8 blurred;
    KeyPoints keypoints;
  };

  const OrbOptions options_;
  int budget_;
  const double edge_ratio_;
  std::vector<Level> levels_;
  std::shared_ptr<const ScalePyramid> pyramid_;
  // Numbers per level: corners found, the least of them and of what the level has room for, keypoints wanted.
  std::vector<int> available_, with_room_, share_;
  KeyPoints keypoints_;
};

}  // namespace covis
