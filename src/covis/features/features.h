// SPDX-License-Identifier: Apache-2.0
// The features of an image: keypoints and descriptors in flat arrays, immutable once made and shared by
// std::shared_ptr<const Features> (architecture.md, decision 4). Monocular, stereo and RGB-D differ only in depth
// (u_right follows from it). Source: Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, section III-A.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <vector>

#include "covis/core/aligned.h"
#include "covis/features/kept_depth.h"
#include "covis/features/patches.h"
#include "covis/features/small_image.h"
#include "covis/geometry/camera.h"

namespace covis {

// 256 bits, compared by Hamming distance; bit i of word i / 64 is comparison i (byte j, bit k = comparison 8 j + k).
struct Descriptor {
  std::array<uint64_t, 4> bits{};
  friend bool operator==(const Descriptor&, const Descriptor&) = default;
};

inline int hamming(const Descriptor& a, const Descriptor& b) {
  return __builtin_popcountll(a.bits[0] ^ b.bits[0]) + __builtin_popcountll(a.bits[1] ^ b.bits[1]) +
         __builtin_popcountll(a.bits[2] ^ b.bits[2]) + __builtin_popcountll(a.bits[3] ^ b.bits[3]);
}

inline constexpr int kHammingBeyond = 257;  // greater than any distance: no match yet
inline constexpr int kHammingHigh = 100;    // greatest distance of a plausible match
inline constexpr int kHammingLow = 50;      // greatest distance of a safe match

// Scale factors of the pyramid. scale[l] = base * factor^l; sigma2[l] = scale[l]^2, the variance (pixels^2) of a
// keypoint on level l. The base is 1 but where keypoints are expressed in another camera's pixels
// (map/camera_change.h).
struct ScalePyramid {
  int levels = 0;
  float factor = 1.2f;
  float base = 1;
  std::vector<float> scale, sigma2, inv_sigma2;

  ScalePyramid() = default;
  ScalePyramid(int levels, float factor, float base = 1);
  // Returns the level at which a point is expected: ceil(log(d_max / distance / base) / log(factor)), in
  // [0, levels - 1].
  int predict_level(float d_max, float distance) const;
};

// Bounding box of the undistorted image corners, pixels.
struct ImageBounds {
  float min_x = 0, min_y = 0, max_x = 0, max_y = 0;
  bool contains(float x, float y) const { return x >= min_x && x < max_x && y >= min_y && y < max_y; }
};

inline constexpr int kMaxFeatures = 65535;  // greatest number of keypoints of an image

// Keypoints bucketed by undistorted position. Most cells are empty, so only filled cells have an offset; they are
// counted row by row. The k-th filled cell holds indices[offsets[k] .. offsets[k + 1]), in ascending order.
struct FeatureGrid {
  static constexpr int kColumns = 64, kRows = 48;
  static constexpr size_t kCells = size_t{kColumns} * kRows;
  ImageBounds bounds;
  float inv_cell_width = 0, inv_cell_height = 0;  // cells per pixel
  std::array<uint64_t, kRows> filled{};           // bit c of row r is set when cell (c, r) is not empty
  std::array<uint16_t, kRows> before{};           // number of filled cells before row r
  // 16-bit values because every key frame stores a grid; kMaxFeatures is their limit.
  std::vector<uint16_t> offsets;  // one per filled cell, and the end
  std::vector<uint16_t> indices;

  void build(const ImageBounds& bounds, const AlignedVector<float>& x, const AlignedVector<float>& y);

  // Calls visit(first, last) for each row of cells under a window, |x - px| <= radius and |y - py| <= radius, that is
  // not empty there: its cells hold indices[first .. last).
  template <class Visit>
  void for_each_run(float px, float py, float radius, Visit&& visit) const {
    const int c0 = std::max(0, static_cast<int>((px - radius - bounds.min_x) * inv_cell_width));
    const int c1 = std::min(kColumns - 1, static_cast<int>((px + radius - bounds.min_x) * inv_cell_width));
    const int r0 = std::max(0, static_cast<int>((py - radius - bounds.min_y) * inv_cell_height));
    const int r1 = std::min(kRows - 1, static_cast<int>((py + radius - bounds.min_y) * inv_cell_height));
    if (c1 < c0) return;
    const uint64_t left_of = (uint64_t{1} << c0) - 1, up_to_last = ~uint64_t{0} >> (kColumns - 1 - c1);
    for (int r = r0; r <= r1; ++r) {
      const uint64_t in_row = filled[static_cast<size_t>(r)];
      if (!(in_row & up_to_last & ~left_of)) continue;
      const uint16_t* row = offsets.data() + before[static_cast<size_t>(r)];
      // The cells of a row are contiguous.
      visit(uint32_t{row[std::popcount(in_row & left_of)]}, uint32_t{row[std::popcount(in_row & up_to_last)]});
    }
  }
};

// How the camera turned while the rows of an image were exposed one after the other (features/unrolling.h).
struct ExposureTurn {
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();  // turn of the rays, radians a second; zero: not known
  double row_time = 0;  // Pinhole::row_time by which it was taken out of the keypoints; 0: it was not

  Eigen::Vector3d taken() const { return row_time * rate; }  // from row to row, radians
};

// As Features has it: null where there is none.
inline std::shared_ptr<const ShiftField> shared_field(const ShiftField& field) {
  return field.any() ? std::make_shared<const ShiftField>(field) : nullptr;
}
inline ShiftField field_of(const std::shared_ptr<const ShiftField>& shared) { return shared ? *shared : ShiftField(); }

struct Features {
  enum class RawPixels { same, different };
  // Removes all keypoints and makes room for `room` of them, and for their raw pixels where those differ.
  void start(size_t room, RawPixels raw);

  // Undistorted pixels, level-0 scale, in the pinhole model of the map's camera. Where a turn was taken out of them
  // they are not where the undistorted image shows them.
  AlignedVector<float> x, y;
  AlignedVector<float> raw_x, raw_y;  // distorted pixels of the input image; empty when equal to x, y: see image_x()
  AlignedVector<float> angle;         // radians in [0, 2 pi)
  AlignedVector<float> u_right;       // column in the (real or virtual) right image; of meaning where there is a depth
  AlignedVector<float> depth;         // metres along z; not positive: no measurement
  AlignedVector<uint8_t> level;       // pyramid level
  AlignedVector<Descriptor> descriptor;
  FeatureGrid grid;
  std::shared_ptr<const ScalePyramid> pyramid;
  std::shared_ptr<const Pinhole> straightened_for;  // the camera whose residual distortion was
                                                    // taken out of x and y; null: none was
  // Stereo: Pinhole::right_columns that were taken out of u_right; null: none were.
  std::shared_ptr<const ShiftField> right_columns;
  bool right_rows_are_off = false;  // stereo: matches show it (right_rows.h)
  ExposureTurn exposure;
  std::shared_ptr<const RefinedCamera> made_by;  // the camera, where it is another one than the map's; else null
  std::shared_ptr<const Camera> lens;            // null: raw pixels are undistorted ones
  std::shared_ptr<Patches> patches;              // null: none were cut, or none are kept
  AlignedVector<uint64_t> anchor;  // key frames: anchor_of() (map/anchors.h); 0: not aligned; empty: none is
  std::shared_ptr<const KeptDepth> kept_depth;  // key frames: null where depths are never looked up again
  SmallImage small;                             // for the next frame alone

  // A copy for a key frame: without the small image, without room for more keypoints, and with patches of its own.
  std::shared_ptr<Features> for_key_frame() const;

  int size() const { return static_cast<int>(x.size()); }
  // A keypoint's pixel without the distortion of the lens that was given, where a registration of depth begins. Unlike
  // x and y it keeps a distortion that was found.
  Eigen::Vector2d pinhole_pixel(size_t i) const;
  const AlignedVector<float>& image_x() const { return raw_x.empty() ? x : raw_x; }
  const AlignedVector<float>& image_y() const { return raw_y.empty() ? y : raw_y; }
  bool has_any_depth() const {
    return std::any_of(depth.begin(), depth.end(), [](float z) { return z > 0; });
  }
  bool has_depth(int i) const { return depth[static_cast<size_t>(i)] > 0; }
};

using FeaturesPtr = std::shared_ptr<const Features>;

}  // namespace covis
