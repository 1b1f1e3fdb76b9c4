// SPDX-License-Identifier: Apache-2.0
#include "covis/features/frontend.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "covis/core/log.h"
#include "covis/core/time.h"
#include "covis/features/depth_lookup.h"
#include "covis/features/extractor.h"
#include "covis/features/features_ring.h"
#include "covis/features/orb.h"
#include "covis/features/right_rows.h"
#include "covis/features/staged_work.h"
#include "covis/features/stereo_matcher.h"
#include "covis/features/straightening.h"

namespace covis {

// Extracts both images of a stereo pair in two threads. (Outside the anonymous namespace because Frontend::Impl has it
// as a member.)
class PairExtractor {
 public:
  PairExtractor(OrbExtractor& left, OrbExtractor& right)
      : side_{&left, &right},
        work_({{2, [this](int k) { side(k).start(image(k)); }},
               {2 * left.levels(), [this](int k) { side(k).detect(k / 2); }},
               {2, [this](int k) { side(k).share_budget(); }},
               {2 * left.levels(), [this](int k) { side(k).describe(k / 2); }},
               {2, [this](int k) { side(k).finish(); }}}) {}

  void extract(ImageView<const uint8_t> left, ImageView<const uint8_t> right) {
    images_ = {left, right};
    work_.run();
  }
  // Right images are resampled so from now on. Returns how they were before.
  std::optional<ResamplingMap> resample(std::optional<ResamplingMap> right) {
    return std::exchange(resampling_, std::move(right));
  }

 private:
  ImageView<const uint8_t> image(int k) {
    const ImageView<const uint8_t> given = images_[static_cast<size_t>(k)];
    if (k == 0 || !resampling_) return given;
    resampling_->apply(given, resampled_);
    return resampled_.view();
  }
  OrbExtractor& side(int k) const { return *side_[static_cast<size_t>(k % 2)]; }

  const std::array<OrbExtractor*, 2> side_;
  std::array<ImageView<const uint8_t>, 2> images_;
  std::optional<ResamplingMap> resampling_;
  ImageU8 resampled_;  // the right one
  StagedWork work_;
};

namespace {

// Bounding box of the undistorted image. Its border tells, unless a part of that is seen at a right angle to the axis
// or beyond, as by a fisheye lens whose circle the image shows: then the pixels within do.
ImageBounds find_bounds(const Camera& camera) {
  const auto w = static_cast<float>(camera.width), h = static_cast<float>(camera.height);
  if (camera.distortion == Distortion::none) return {0, 0, w, h};
  constexpr int kSteps = 32;
  std::optional<ImageBounds> box;
  const auto take = [&](int across, int down) {  // False: the pixel has no place in an undistorted image.
    const auto u = camera.undistort({static_cast<double>(across) / kSteps * w, static_cast<double>(down) / kSteps * h});
    if (!u) return false;
    const auto x = static_cast<float>(u->x()), y = static_cast<float>(u->y());
    if (!box) box = {x, y, x, y};
    box = {std::min(box->min_x, x), std::min(box->min_y, y), std::max(box->max_x, x), std::max(box->max_y, y)};
    return true;
  };
  bool whole = true;
  for (int k = 0; k <= kSteps; ++k) {
    for (const auto& [across, down] : std::array<std::pair<int, int>, 4>{{{k, 0}, {k, kSteps}, {0, k}, {kSteps, k}}})
      whole &= take(across, down);
  }
  for (int k = 0; !whole && k <= kSteps; ++k) {
    for (int m = 0; m <= kSteps; ++m) take(m, k);
  }
  if (!box) return {0, 0, w, h};
  // The corners of a fisheye image map very far out; bounds more than an image size outside are useless.
  return {std::max(box->min_x, -w), std::max(box->min_y, -h), std::min(box->max_x, 2 * w), std::min(box->max_y, 2 * h)};
}

OrbOptions for_images_of(const Camera& camera, OrbOptions options) {
  options.levels = pyramid_levels(options, camera.width, camera.height);
  return options;
}

void cut_patches(const OrbExtractor& from, Features& f) {
  constexpr int kSide = Patch::kSide;
  static_assert(kSide / 2 < kEdgeBorder, "a keypoint's patch lies within its level");
  f.patches = held_alone(std::move(f.patches));
  Patches& patches = *f.patches;
  patches.stretch.clear();
  for (int l = 0; l < from.levels(); ++l) patches.stretch.push_back(from.to_image(l, 1, 1) - from.to_image(l, 0, 0));
  patches.at.reserve(from.most_keypoints());
  patches.at.resize(f.x.size());
  const AlignedVector<float>&x = f.image_x(), &y = f.image_y();
  for (size_t i = 0; i < patches.at.size(); ++i) {
    const int l = f.level[i];
    const Eigen::Vector2f centre = from.to_level(l, x[i], y[i]);
    const int left = static_cast<int>(std::lround(centre.x())) - kSide / 2;
    const int top = static_cast<int>(std::lround(centre.y())) - kSide / 2;
    Patch& patch = patches.at[i];
    patch.origin = from.to_image(l, static_cast<float>(left), static_cast<float>(top));
    const ImageView<const uint8_t> level = from.level(l);
    for (int row = 0; row < kSide; ++row)
      std::copy_n(level.row(top + row) + left, kSide, patch.grey.data() + static_cast<ptrdiff_t>(row) * kSide);
  }
}

}  // namespace

Fields fields(OrbOptions& o) {
  return {
      {"orb.features", &o.features, "keypoints wanted in an image", 50, 30000},
      {"orb.levels", &o.levels, "pyramid levels; 0: 8, and more for images of more than 575 lines", 0, kMostLevels},
      {"orb.scale_factor", &o.scale_factor, "scale between levels", 1.05, 2},
      {"orb.fast_threshold", &o.fast_threshold, "FAST contrast, first try in a cell, grey levels", 1, 255},
      {"orb.fast_threshold_low", &o.fast_threshold_low,
       "FAST contrast where the first try found no corner, grey levels", 1, 255},
      {"orb.edge_ratio_mono", &o.edge_ratio_mono,
       "monocular: corners whose structure tensor has a greater ratio of eigenvalues lie on edges and are left "
       "out; 0: none",
       0, 1000},
      {"orb.subpixel", &o.subpixel, "place keypoints at the top of the corner score's parabola, not at the pixel"},
      {"orb.refine_rows", &o.refine_rows, "stereo: find how far the right image's rows are off, and resample it so"},
      {"orb.patches", &o.patches,
       "keep the grey levels around keypoints, with which the places of matches are refined"}};
}

int pyramid_levels(const OrbOptions& options, int width, int height) {
  constexpr int kGreat = 576;        // lines
  constexpr double kCoarsest = 160;  // pixels, of the coarsest level's shorter side
  if (options.levels > 0) return options.levels;
  int levels = kFewestLevels;
  if (std::min(width, height) < kGreat) return levels;
  double side = std::min(width, height) / std::pow(options.scale_factor, levels - 1);
  for (; side > kCoarsest && levels < kMostLevels; ++levels) side /= options.scale_factor;
  return levels;
}

struct Frontend::Impl {
  Impl(const Camera& c, const OrbOptions& options, Sensor sensor)
      : camera(c),
        lens(distorted() ? std::make_shared<const Camera>(c) : nullptr),
        cuts_patches(options.patches),
        bounds(find_bounds(c)),
        registration(c.pinhole.registration),
        left(for_images_of(c, options), sensor == Sensor::monocular ? options.edge_ratio_mono : 0) {
    if (sensor == Sensor::stereo) {
      right.emplace(for_images_of(c, options));
      pair.emplace(left, *right);
      if (options.refine_rows) rows.emplace(c);
    }
  }

  bool distorted() const { return camera.distortion != Distortion::none; }
  std::shared_ptr<Features> finish(ImageView<const float> depth_image);
  Pinhole pair_camera() const;
  void find_rows(ImageView<const uint8_t> left_image, ImageView<const uint8_t> right_image, const Features& features);

  const Camera camera;
  const std::shared_ptr<const Camera> lens;  // null: no distortion
  const bool cuts_patches;
  ImageBounds bounds;
  std::shared_ptr<const Pinhole> refined;  // null: undistorted keypoints stay as they are
  DepthRegistration registration;
  OrbExtractor left;
  const ImageProbe probe{camera, left};
  std::optional<OrbExtractor> right;
  std::optional<PairExtractor> pair;
  StereoMatcher matcher;
  std::optional<RightRows> rows;                    // null: not looked for
  std::optional<ShiftField> better_rows;            // found, and not taken yet
  std::shared_ptr<const ShiftField> right_columns;  // those of the camera that is followed
  SmallImageMaker small;
  FeaturesRing ring;
  Timing timing;
};

// Makes undistorted features from the left extractor's keypoints, without depth.
std::shared_ptr<Features> Frontend::Impl::finish(ImageView<const float> depth_image) {
  const KeyPoints& k = left.keypoints();
  const Eigen::Vector2d centre(camera.pinhole.cx, camera.pinhole.cy);
  std::shared_ptr<Features> f = ring.next();
  f->pyramid = left.pyramid();
  f->straightened_for = refined;
  f->lens = lens;
  f->right_columns = right_columns;
  f->right_rows_are_off = better_rows || (rows && rows->field().any());
  const size_t n = k.size();
  f->start(std::max(n, left.most_keypoints()),
           distorted() || refined ? Features::RawPixels::different : Features::RawPixels::same);
  for (size_t i = 0; i < n; ++i) {
    Eigen::Vector2f at(k.x[i], k.y[i]);
    Eigen::Vector2f pinhole_pixel = at;
    if (distorted() || refined) {
      auto u = camera.undistort(at.cast<double>());
      if (u) pinhole_pixel = u->cast<float>();
      if (u && refined) u = refined->straightened(*u);
      if (!u) continue;
      at = u->cast<float>();
      if (!bounds.contains(at.x(), at.y())) continue;
      f->raw_x.push_back(k.x[i]);
      f->raw_y.push_back(k.y[i]);
    }
    float depth = 0;
    if (!depth_image.empty()) {
      const float scale = f->pyramid->scale[k.level[i]];
      depth = registration.any()
                  ? depth_at(depth_image, registration, centre, pinhole_pixel.x(), pinhole_pixel.y(), scale)
                  : depth_at(depth_image, k.x[i], k.y[i], scale);
    }
    f->x.push_back(at.x());
    f->y.push_back(at.y());
    f->angle.push_back(k.angle[i]);
    f->level.push_back(k.level[i]);
    f->descriptor.push_back(k.descriptor[i]);
    f->depth.push_back(depth);
    f->u_right.push_back(depth > 0 ? at.x() - static_cast<float>(camera.pinhole.bf) / depth : -1.0f);
  }
  f->grid.build(bounds, f->x, f->y);
  small.make(left.level(0), f->small);
  if (cuts_patches) cut_patches(left, *f);
  return f;
}

// The camera whose columns are taken out of disparities.
Pinhole Frontend::Impl::pair_camera() const {
  Pinhole made = camera.pinhole;
  made.right_columns = field_of(right_columns);
  if (rows) made.right_columns = made.right_columns + rows->columns();
  return made;
}

// By the pair that was matched last, for pairs to come, once the columns are known as well: rows alone would make
// depths worse where both were calibrated together. That pair is matched once more to see what it does to columns.
void Frontend::Impl::find_rows(ImageView<const uint8_t> left_image, ImageView<const uint8_t> right_image,
                               const Features& features) {
  if (!rows) return;
  if (const auto found = rows->add(matcher.row_differences())) better_rows = found;
  if (!better_rows || !right_columns) return;
  const std::optional<ShiftField> field = std::exchange(better_rows, std::nullopt);
  auto before = pair->resample(rows->resampling(*field));
  pair->extract(left_image, right_image);
  Pinhole plain = camera.pinhole;
  plain.right_columns = *right_columns;
  AlignedVector<float> u_right, depth;
  matcher.match(left, *right, plain, u_right, depth);
  std::vector<ColumnDifference> differences;
  for (size_t i = 0; i < u_right.size() && i < features.u_right.size(); ++i) {
    if (depth[i] > 0 && features.depth[i] > 0)
      differences.push_back({u_right[i], features.y[i], u_right[i] - features.u_right[i]});
  }
  if (rows->take(*field, differences)) {
    log(LogLevel::info, "the right image's rows are not rectified: " + rows->description());
  } else {
    pair->resample(std::move(before));
  }
}

Frontend::Frontend(const Camera& camera, const OrbOptions& options, Sensor sensor)
    : impl_(std::make_unique<Impl>(camera, options, sensor)) {}
Frontend::~Frontend() = default;

const Frontend::Timing& Frontend::timing() const { return impl_->timing; }

const DepthRegistration& Frontend::registration() const { return impl_->registration; }

const ImageProbe& Frontend::probe() const { return impl_->probe; }

double Frontend::row_error() const { return impl_->matcher.row_error(); }

void Frontend::set_feature_budget(int features) {
  impl_->left.set_budget(features);
  if (impl_->right) impl_->right->set_budget(features);
}

void Frontend::follow(const Pinhole& refined) {
  impl_->registration = refined.registration;
  if (field_of(impl_->right_columns) != refined.right_columns)
    impl_->right_columns = shared_field(refined.right_columns);
  if (impl_->refined ? *impl_->refined == refined : !refined.residual.any()) return;
  impl_->refined = refined.residual.any() ? std::make_shared<const Pinhole>(refined) : nullptr;
  impl_->bounds = straightened(find_bounds(impl_->camera), refined);
}

FeaturesPtr Frontend::monocular(ImageView<const uint8_t> image) {
  const Stopwatch watch;
  impl_->left.extract(image);
  FeaturesPtr features = impl_->finish({});
  impl_->timing = {watch.ms(), 0};
  return features;
}

FeaturesPtr Frontend::rgbd(ImageView<const uint8_t> image, ImageView<const float> depth) {
  Stopwatch watch;
  impl_->left.extract(image);
  impl_->timing.extract_ms = watch.lap();
  FeaturesPtr features = impl_->finish(depth);
  impl_->timing.depth_ms = watch.ms();
  return features;
}

FeaturesPtr Frontend::stereo(ImageView<const uint8_t> left, ImageView<const uint8_t> right) {
  Stopwatch watch;
  impl_->pair->extract(left, right);
  impl_->timing.extract_ms = watch.lap();
  std::shared_ptr<Features> features = impl_->finish({});
  impl_->matcher.match(impl_->left, *impl_->right, impl_->pair_camera(), features->u_right, features->depth);
  impl_->find_rows(left, right, *features);
  impl_->timing.depth_ms = watch.ms();
  return features;
}

}  // namespace covis
