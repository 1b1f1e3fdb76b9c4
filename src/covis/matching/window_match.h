// SPDX-License-Identifier: Apache-2.0
// Matching by prediction: for each query, the most similar keypoint inside a window of the image. Serves the motion
// model, the local map, the monocular initialiser and fusion. Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO
// 2015, sections V-B, V-D and VI-D.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "covis/features/features.h"
#include "covis/geometry/camera.h"

namespace covis {

// A descriptor that is looked for, and the window. Pixels are undistorted.
struct WindowQuery {
  float u = 0, v = 0;
  float disparity = 0;               // expected, pixels; 0: not checked
  float radius = 0;                  // half the window's side
  int min_level = 0, max_level = 0;  // the least may be -1; the greatest is not less
  const Descriptor* descriptor = nullptr;
};

struct WindowMatchOptions {
  int max_distance = kHammingHigh;  // greatest Hamming distance of a match
  float ratio = 1.0f;               // best < ratio x second best, asked only when both are of one level; 1: not asked
  bool within_bound = false;        // true: a match's reprojection error must be within its 95 % bound
};

// match[q] becomes the index of the feature matched to query q, kUnlike or kGivenAway. A feature goes to at most one
// query: the most similar, on a tie the earlier. Features with taken[i] != 0 are passed over (empty span: none).
// Returns the number of matches. Allocates nothing once the vectors have grown.
class WindowMatcher {
 public:
  static constexpr int32_t kUnlike = -1;     // no feature of the window is similar enough, or by far the most
  static constexpr int32_t kGivenAway = -2;  // another query got the most similar feature

  int match(const Features& features, std::span<const WindowQuery> queries, std::span<const uint8_t> taken,
            const Pinhole& camera, const WindowMatchOptions& options, std::vector<int32_t>& match);

 private:
  struct Owner {
    int32_t query = -1;
    int32_t distance = 0;
  };
  // The features' positions and levels in the order of their grid, so that those of a window lie side by side.
  struct InGridOrder {
    std::vector<float> x, y;
    std::vector<uint8_t> level;

    void gather(const Features& features);
  };
  // The features in a query's window, in the order of the grid. Valid until the next call.
  std::span<const uint16_t> in_window(const Features& features, const WindowQuery& query);

  InGridOrder ordered_;
  std::vector<uint16_t> inside_;
  std::vector<Owner> owner_;
};

// Drops matches whose change of orientation disagrees with the bulk: of a histogram of the angle differences (30 bins
// around the circle), only the three neighbouring bins that hold most stay. angle_a[k] and angle_b[k] (radians) belong
// to match k; matches with keep[k] == 0 are not looked at, keep[k] becomes 0 for the dropped. Returns the number kept.
int check_rotation(std::span<const float> angle_a, std::span<const float> angle_b, std::vector<uint8_t>& keep);

}  // namespace covis
