// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/sensor_monitor.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace covis {
namespace {

// The bounds lie between what good recordings and faulty ones show (docs/notes/033-depth-to-be-believed.md).
constexpr double kLeastShareStereo = 0.15, kLeastShareRgbd = 0.05;
constexpr double kMostZero = 0.7;       // share of matches
constexpr double kMostRowError = 0.85;  // sigmas of a keypoint
constexpr double kLeastNear = 0.2;      // metres: no depth camera sees nearer
constexpr double kMostError = 0.85;     // DepthAgainstMotion::error()
constexpr size_t kFew = 3;              // comparisons that suffice where the error is great
constexpr double kMostErrorOfFew = 1.1;
constexpr double kMostExplained = 0.6;  // DepthAgainstMotion::explained of depth that may be wrong
constexpr double kEndsBelow = 0.6;      // the error at which a doubt ends
constexpr double kLeastSpread = 0.06;   // below it depth is right, however flat the scene
constexpr int kLeastFeatures = 100;     // keypoints without which a frame says nothing

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
    case SensorDoubt::depth_against_motion:
      return "depth_against_motion";
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
      return text("%.0f %% of the matches between left and right image have no disparity: are both the same image?",
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
    case SensorDoubt::depth_against_motion:
      return text(stereo ? "the depth of the stereo pair contradicts the motion of the images (error %.2f, where a "
                           "constant depth has 1 and a good pair 0.1): is the right image of the same moment, and the "
                           "calibration right?"
                         : "depth contradicts the motion of the images (error %.2f, where a constant depth has 1 and a "
                           "good camera less than 0.5): is it registered to the image, and of the same moment?",
                  warning.figure);
  }
  return {};
}

void SensorMonitor::add_frame(int64_t frame, const Features& f, double row_error) {
  if (sensor_ == Sensor::monocular || f.size() < kLeastFeatures) return;
  depths_.clear();
  int zero = 0;
  for (size_t i = 0; i < f.depth.size(); ++i) {
    if (!(f.depth[i] > 0)) continue;
    depths_.push_back(static_cast<double>(f.depth[i]));
    zero += f.x[i] - f.u_right[i] < 1;
  }
  const auto known = static_cast<double>(depths_.size());
  share_.add(known / f.size());
  const bool stereo = sensor_ == Sensor::stereo;
  const double share = share_.median(kFrames);
  if (share_.full())
    judge(SensorDoubt::few_depths, share < (stereo ? kLeastShareStereo : kLeastShareRgbd), share, frame);
  if (depths_.empty()) return;
  if (stereo) {
    zero_.add(zero / known);
    rows_.add(row_error);
    if (zero_.full()) judge(SensorDoubt::no_disparity, zero_.median(kFrames) > kMostZero, zero_.median(kFrames), frame);
    if (rows_.full())
      judge(SensorDoubt::rows_differ, rows_.median(kFrames) > kMostRowError, rows_.median(kFrames), frame);
    return;
  }
  const auto tenth = depths_.begin() + static_cast<ptrdiff_t>(depths_.size() / 10);
  std::nth_element(depths_.begin(), tenth, depths_.end());
  near_.add(*tenth);
  if (near_.full())
    judge(SensorDoubt::depth_too_near, near_.median(kFrames) < kLeastNear, near_.median(kFrames), frame);
}

void SensorMonitor::add_comparison(int64_t frame, const DepthAgainstMotion& comparison) {
  error_.add(comparison.explained < kMostExplained ? comparison.error() : 0);
  spread_.add(comparison.spread);
  const auto exceeded = [&](size_t last, double most) {
    return error_.count >= last && error_.median(last) > most && spread_.median(last) > kLeastSpread;
  };
  const bool doubted = wrong_[static_cast<size_t>(SensorDoubt::depth_against_motion)];
  const bool is_wrong = exceeded(kFew, kMostErrorOfFew) || exceeded(kComparisons, kMostError) ||
                        (doubted && error_.median(kComparisons) > kEndsBelow);
  judge(SensorDoubt::depth_against_motion, is_wrong, error_.median(std::min(error_.count, kComparisons)), frame);
}

// A wrong scale alone leaves poses right up to it.
bool SensorMonitor::doubts() const {
  for (size_t k = 0; k < kSensorDoubts; ++k) {
    if (wrong_[k] && static_cast<SensorDoubt>(k) != SensorDoubt::depth_too_near) return true;
  }
  return false;
}

void SensorMonitor::judge(SensorDoubt doubt, bool is_wrong, double figure, int64_t frame) {
  const auto k = static_cast<size_t>(doubt);
  wrong_[k] = is_wrong;
  if (!is_wrong || told_[k]) return;
  told_[k] = true;
  fresh_.push_back({doubt, figure, frame});
}

}  // namespace covis
