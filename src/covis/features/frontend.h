// SPDX-License-Identifier: Apache-2.0
// From images to Features: the one place where monocular, stereo and RGB-D differ (architecture.md, decision 7).
#pragma once

#include <memory>

#include "covis/core/error.h"
#include "covis/core/fields.h"
#include "covis/core/image.h"
#include "covis/core/sensor.h"
#include "covis/features/features.h"
#include "covis/features/image_probe.h"
#include "covis/geometry/camera.h"

namespace covis {

inline constexpr int kFewestLevels = 8, kMostLevels = 16;  // bounds of pyramid_levels()

struct OrbOptions {
  int features = 1000;         // number of keypoints wanted in an image
  int levels = 0;              // pyramid levels; 0: as images of this size need (pyramid_levels)
  double scale_factor = 1.2;   // scale between levels
  int fast_threshold = 20;     // FAST contrast of the first attempt in a cell
  int fast_threshold_low = 7;  // FAST contrast of the second attempt, where the first found no corner
  // Monocular: greatest ratio of the eigenvalues of a corner's structure tensor; what exceeds it lies on an edge and is
  // left out (gradients.h). 0: any ratio.
  double edge_ratio_mono = 18;
  bool subpixel = true;     // place keypoints at the maximum of the corner score's parabola, not at the pixel
  bool refine_rows = true;  // stereo: find how far the right image's rows are off, and resample it (right_rows.h)
  bool patches = true;      // keep the grey levels around keypoints, with which the places of matches are refined
};
Fields fields(OrbOptions& options);
// The number of pyramid levels of images of this size, where OrbOptions::levels is 0: 8; of great images as many more,
// up to 16, as make the coarsest level as small as theirs. Great images are seldom sharp to the pixel, and motion blurs
// more of their pixels (docs/notes/058-levels-of-great-images.md).
int pyramid_levels(const OrbOptions& options, int width, int height);

// Makes Features from images. It owns its scratch memory: an extraction allocates nothing in the steady state. Features
// are reused once nobody holds them, so a user who keeps them for more than a few frames must copy them. Not
// thread-safe; use one per tracker.
class Frontend {
 public:
  // camera: the (left) image's camera. pinhole.bf must be set for stereo (rectified, no distortion) and RGB-D.
  Frontend(const Camera& camera, const OrbOptions& options, Sensor sensor);
  ~Frontend();
  Frontend(const Frontend&) = delete;
  Frontend& operator=(const Frontend&) = delete;

  // Duration of the stages of the last call, milliseconds.
  struct Timing {
    double extract_ms = 0;  // pyramid, corners, quadtree, orientation, descriptors (for stereo: both images)
    double depth_ms = 0;    // stereo matching or depth look-up
  };
  const Timing& timing() const;

  // Sets the number of keypoints wanted (the monocular initialiser uses more than tracking does).
  void set_feature_budget(int features);

  // From now on keypoints are made free of this camera's residual distortion (not of pairs, whose columns must stay),
  // depths are looked up by its registration, and disparities are made free of its right_columns.
  void follow(const Pinhole& refined);
  const DepthRegistration& registration() const;

  // Images must have the camera's size (asserted; readers check it before).
  FeaturesPtr monocular(ImageView<const uint8_t> image);
  // Processes a rectified pair; both images are extracted in parallel by two threads.
  FeaturesPtr stereo(ImageView<const uint8_t> left, ImageView<const uint8_t> right);
  // StereoMatcher::row_error() of the last pair.
  double row_error() const;
  // depth: metres, same size, registered to the image unless follow() said how it is; 0 or non-finite: no measurement.
  FeaturesPtr rgbd(ImageView<const uint8_t> image, ImageView<const float> depth);

  // Looks at the last (left) image, until the next one is taken.
  const ImageProbe& probe() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace covis
