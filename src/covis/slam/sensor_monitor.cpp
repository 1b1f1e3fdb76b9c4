// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/sensor_monitor.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace covis {
namespace {

// The bounds lie between what good recordings and faulty ones show (docs/notes/033-depth-to-be-believed.md).
constexpr double kLeastShareStereo = 0.15, kLeastShareRgbd = 0.05;
constexpr double kMostZero = 0.7;       // share of matches
constexpr float kNoDisparity = 1;       // pixels: the fractions of equal patches are not 0
constexpr double kSameRow = 0.05;       // sigmas of a keypoint: no two cameras give it
constexpr double kMostRowError = 0.85;  // sigmas of a keypoint
constexpr double kLeastNear = 0.2;      // metres: no depth camera sees nearer
constexpr double kLeastRelief = 0.001;  // noise alone is more, and a wall is not so straight ahead
constexpr double kMostError = 0.85;     // DepthAgainstMotion::error()
constexpr size_t kFew = 3;              // comparisons that suffice where the error is great
constexpr double kMostErrorOfFew = 1.1;
constexpr double kMostExplained = 0.55;  // DepthAgainstMotion::explained of depth that may be wrong
constexpr double kEndsBelow = 0.6;       // the error at which a doubt ends
constexpr double kLeastSpread = 0.06;    // below it depth is right, however flat the scene
constexpr size_t kLeastDepths = 50;      // depths without which a frame says nothing of its relief
constexpr int kLeastFeatures = 100;      // keypoints without which a frame says nothing

std::string text(const char* pattern, double figure) {
  char line[400];
  std::snprintf(line, sizeof line, pattern, figure);
  return line;
}

}  // namespace

std::string_view name(SensorDoubt doubt) {
  switch (doubt) {
    case SensorDoubt::few_depths:
      return "few_depths";
    case SensorDoubt::no_disparity:
      return "no_disparity";
    case SensorDoubt::rows_differ:
      return "rows_differ";
    case SensorDoubt::depth_too_near:
      return "depth_too_near";
    case SensorDoubt::no_relief:
      return "no_relief";
    case SensorDoubt::depth_against_motion:
      return "depth_against_motion";
    case SensorDoubt::depth_against_map:
      return "depth_against_map";
    case SensorDoubt::depth_displaced:
      return "depth_displaced";
    case SensorDoubt::outlines_fit_nowhere:
      return "outlines_fit_nowhere";
    case SensorDoubt::depth_frozen:
      return "depth_frozen";
    case SensorDoubt::images_torn:
      return "images_torn";
  }
  return "";
}

std::string describe(const SensorWarning& warning, Sensor sensor) {
  const bool stereo = sensor == Sensor::stereo;
  switch (warning.doubt) {
    case SensorDoubt::few_depths:
      if (stereo)
        return text(
            "only %.0f %% of the left keypoints have a match in the right image: is the pair rectified, of one "
            "moment, and the left image the left one?",
            100 * warning.figure);
      return text(
          "only %.0f %% of the keypoints have a depth: is the scene within the depth camera's reach, and the "
          "depth registered to the image?",
          100 * warning.figure);
    case SensorDoubt::no_disparity:
      return text("%.0f %% of the matches between left and right image are at the same place: are both the same image?",
                  100 * warning.figure);
    case SensorDoubt::rows_differ:
      return text(
          "matched keypoints of left and right image differ in their rows (median %.2f sigmas; 0.4 is usual): is "
          "the pair rectified, with the right calibration, and of one moment?",
          warning.figure);
    case SensorDoubt::depth_too_near:
      return text(
          "a tenth of the keypoints are nearer than %.2f m, where depth cameras see nothing: is depth_scale "
          "right?",
          warning.figure);
    case SensorDoubt::no_relief:
      return text(
          "all keypoints have the same depth (eight of ten within a range of %.5f of it): are these images of depth?",
          warning.figure);
    case SensorDoubt::depth_against_motion:
      return text(stereo ? "the depth of the stereo pair contradicts the motion of the images (error %.2f, where a "
                           "constant depth has 1 and a good pair 0.1): is the right image of the same moment, and the "
                           "calibration right?"
                         : "depth contradicts the motion of the images (error %.2f, where a constant depth has 1 and a "
                           "good camera less than 0.5): is it registered to the image, and of the same moment?",
                  warning.figure);
    case SensorDoubt::depth_against_map:
      return text(
          "depth contradicts the map that was made before (by %.2f in the median; 0.01 is usual): did the depth or the "
          "right image fail, or was the depth before wrong? Frames are tracked by their image alone",
          warning.figure);
    case SensorDoubt::depth_displaced:
      return text(
          "outlines of depth fit the edges of the image %.1f times better shifted, mirrored, turned or scaled than "
          "where "
          "they are: is depth registered to the image, and the same way up?",
          warning.figure);
    case SensorDoubt::outlines_fit_nowhere:
      return text(
          "outlines of depth do not lie where the image has edges (%.1f standard deviations more than by chance; 8 to "
          "40 are usual): is depth of the same moment as the image, and registered to it?",
          warning.figure);
    case SensorDoubt::depth_frozen:
      return text(
          "%.0f depth images in a row are the same while the image changes: does the depth camera or its driver give "
          "the last one again and again?",
          warning.figure);
    case SensorDoubt::images_torn:
      return text(
          "some rows of %.0f images in a row show known things far from where the other rows have them: does a cable, "
          "a "
          "buffer or a driver lose data? Nothing is mapped from such frames",
          warning.figure);
  }
  return {};
}

void SensorMonitor::add_frame(int64_t frame, const Features& f, double row_error, Budget budget) {
  if (sensor_ == Sensor::monocular) return;
  depths_.clear();
  if (f.size() >= kLeastFeatures) {
    for (const float depth : f.depth) {
      if (depth > 0) depths_.push_back(static_cast<double>(depth));
    }
  }
  // A doubt of frames that say nothing any more ends.
  if (f.size() >= kLeastFeatures && (sensor_ == Sensor::rgbd || budget == Budget::usual)) {
    add_share(frame, static_cast<double>(depths_.size()) / f.size());
  } else if (++silence_.share >= kFrames) {
    forget_share();
  }
  if (depths_.empty()) {
    if (++silence_.depths >= kFrames) forget_depths();
    return;
  }
  silence_.depths = 0;
  if (sensor_ == Sensor::stereo) {
    add_disparities(frame, f, row_error);
  } else {
    add_depths(frame);
  }
}

void SensorMonitor::add_share(int64_t frame, double share) {
  silence_.share = 0;
  share_.add(share);
  if (!share_.full()) return;
  const double median = share_.median(kFrames);
  judge(SensorDoubt::few_depths, median < (sensor_ == Sensor::stereo ? kLeastShareStereo : kLeastShareRgbd), median,
        frame);
}

void SensorMonitor::add_disparities(int64_t frame, const Features& f, double row_error) {
  int zero = 0;
  for (size_t i = 0; i < f.depth.size(); ++i) zero += f.depth[i] > 0 && f.x[i] - f.u_right[i] < kNoDisparity;
  depth_figures_.zero.add(zero / static_cast<double>(depths_.size()));
  depth_figures_.rows.add(row_error);
  if (!depth_figures_.rows.full()) return;
  const double share = depth_figures_.zero.median(kFrames), rows = depth_figures_.rows.median(kFrames);
  judge(SensorDoubt::no_disparity, share > kMostZero && rows < kSameRow, share, frame);
  judge(SensorDoubt::rows_differ, rows > kMostRowError, rows, frame);
}

void SensorMonitor::add_depths(int64_t frame) {
  const auto after = [&](size_t tenths) {
    const auto at = depths_.begin() + static_cast<ptrdiff_t>(depths_.size() * tenths / 10);
    std::nth_element(depths_.begin(), at, depths_.end());
    return *at;
  };
  const double nearest = after(1), middle = after(5), farthest = after(9);
  depth_figures_.near.add(nearest);
  depth_figures_.relief.add(depths_.size() < kLeastDepths ? 1 : (farthest - nearest) / middle);
  if (!depth_figures_.near.full()) return;
  const double near = depth_figures_.near.median(kFrames), relief = depth_figures_.relief.median(kFrames);
  judge(SensorDoubt::depth_too_near, near < kLeastNear, near, frame);
  judge(SensorDoubt::no_relief, relief < kLeastRelief, relief, frame);
}

// The rule for few holds as long as there are few: later, two wrong motions of three are too likely. What ends a doubt
// has to be a small error: of few points chance explains much.
void SensorMonitor::add_comparison(int64_t frame, const DepthAgainstMotion& comparison) {
  const bool doubted = holds(SensorDoubt::depth_against_motion);
  auto &errors = comparisons_.error, &spreads = comparisons_.spread;
  errors.add(doubted || comparison.explained < kMostExplained ? comparison.error() : 0);
  spreads.add(comparison.spread);
  const auto exceeds = [&](size_t last, double most) {
    return errors.median(last) > most && spreads.median(last) > kLeastSpread;
  };
  const size_t count = std::min(errors.count, kComparisons);
  const bool are_few = errors.count < kComparisons;
  const bool exceeded = are_few ? count >= kFew && exceeds(kFew, kMostErrorOfFew) : exceeds(kComparisons, kMostError);
  const bool goes_on = doubted && errors.median(count) > kEndsBelow;
  judge(SensorDoubt::depth_against_motion, exceeded || goes_on, errors.median(are_few ? std::min(count, kFew) : count),
        frame);
}

// What a map on probation is asked makes no doubt: a camera that goes straight ahead gives no answer that could end it.
bool SensorMonitor::add_view(int64_t frame, Timestamp stamp, FeaturesPtr features, const Pinhole& camera) {
  constexpr double kEvery = 0.19;  // seconds, three frames at 15 Hz: sooner another view is hardly seen
  constexpr double kFirst = 5;     // seconds
  constexpr int kConfirmed = 3;    // answers in a row
  using Pace = MotionDepthCheck::Pace;
  if (sensor_ == Sensor::monocular) return false;
  auto& [check, last, begun, agreeing] = comparisons_.of_frames;
  const bool doubted = holds(SensorDoubt::depth_against_motion);
  const bool asked_for = doubted || comparisons_.trust == MapTrust::on_probation;
  const bool first = comparisons_.error.count < kComparisons && (!begun || to_seconds(stamp - *begun) < kFirst);
  if (!begun) begun = stamp;
  if (!asked_for && !first) {
    comparisons_.of_frames = {.begun = begun};
  } else if (!last || to_seconds(stamp) - to_seconds(*last) > kEvery) {
    last = stamp;
    for (const DepthAgainstMotion& comparison : check.add(std::move(features), camera, Pace::every_view)) {
      if (doubted || first) add_comparison(frame, comparison);
      if (asked_for)
        agreeing = comparison.error() < kEndsBelow && comparison.explained > kMostExplained ? agreeing + 1 : 0;
    }
  }
  return agreeing >= kConfirmed;
}

void SensorMonitor::add_images(int64_t frame, ImageView<const uint8_t> image, ImageView<const float> depth,
                               const DepthRegistration& registration) {
  const int equal = depth_images_.frozen.add(image, depth);
  judge(SensorDoubt::depth_frozen, equal > 0, equal, frame);
  if (registration.any()) return forget_outlines();  // looked up by it, depth images are not where images have it
  if (!depth_images_.answers.is_next_due()) return;
  if (const auto fit = depth_images_.outlines.add(image, depth)) add_outlines(frame, *fit);
}

void SensorMonitor::add_outlines(int64_t frame, const OutlineFit& fit) {
  OutlineAnswers& answers = depth_images_.answers;
  answers.add(fit);
  judge(SensorDoubt::depth_displaced, answers.are_displaced(), fit.ratio(), frame);
  judge(SensorDoubt::outlines_fit_nowhere, answers.fit_nowhere(), answers.fit(), frame);
}

void SensorMonitor::add_map_comparison(int64_t frame, double contradiction) {
  constexpr int kInARow = 5;
  int& contradictions = in_a_row_.contradictions;
  contradictions = contradiction > 0 ? contradictions + 1 : 0;
  judge(SensorDoubt::depth_against_map, contradictions >= kInARow, contradiction, frame);
}

void SensorMonitor::add_rows(int64_t frame, Rows rows) {
  constexpr int kInARow = 2;
  int& torn = in_a_row_.torn;
  torn = rows == Rows::displaced ? torn + 1 : 0;
  judge(SensorDoubt::images_torn, torn >= kInARow, torn, frame);
}

// A wrong scale alone leaves poses right up to it, and few depths those that the images tell.
bool SensorMonitor::doubts() const {
  return doubts_depth() || holds(SensorDoubt::no_disparity) || holds(SensorDoubt::rows_differ) ||
         holds(SensorDoubt::no_relief) || (sensor_ == Sensor::stereo && holds(SensorDoubt::few_depths));
}

bool SensorMonitor::suspects_depth() const {
  const auto was_told = [this](SensorDoubt doubt) { return told_[static_cast<size_t>(doubt)]; };
  return was_told(SensorDoubt::depth_against_motion) || was_told(SensorDoubt::depth_against_map) ||
         was_told(SensorDoubt::depth_displaced) || was_told(SensorDoubt::outlines_fit_nowhere) ||
         was_told(SensorDoubt::depth_frozen);
}

void SensorMonitor::forget_share() {
  share_ = {};
  wrong_[static_cast<size_t>(SensorDoubt::few_depths)] = false;
}

void SensorMonitor::forget_depths() {
  depth_figures_ = {};
  for (const SensorDoubt doubt :
       {SensorDoubt::no_disparity, SensorDoubt::rows_differ, SensorDoubt::depth_too_near, SensorDoubt::no_relief})
    wrong_[static_cast<size_t>(doubt)] = false;
}

void SensorMonitor::forget_outlines() {
  depth_images_.answers = {};
  for (const SensorDoubt doubt : {SensorDoubt::depth_displaced, SensorDoubt::outlines_fit_nowhere})
    wrong_[static_cast<size_t>(doubt)] = false;
}

void SensorMonitor::judge(SensorDoubt doubt, bool is_wrong, double figure, int64_t frame) {
  const auto k = static_cast<size_t>(doubt);
  wrong_[k] = is_wrong;
  if (!is_wrong || told_[k]) return;
  told_[k] = true;
  fresh_.push_back({doubt, figure, frame});
}

}  // namespace covis
