// SPDX-License-Identifier: Apache-2.0
// Watches whether images, and the depth of a stereo pair or a depth camera, can be believed: by what the features of
// each frame have, and by what comparisons with the motion of the images say (mapping/depth_against_motion.h). It
// changes nothing. While doubts() holds, poses count as tentative; while doubts_depth() holds, neither the noise of
// depth nor the focal length is estimated.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "covis/core/sensor.h"
#include "covis/core/time.h"
#include "covis/features/depth_outlines.h"
#include "covis/features/features.h"
#include "covis/features/frozen_depth.h"
#include "covis/mapping/depth_against_motion.h"
#include "covis/slam/outline_answers.h"

namespace covis {

enum class SensorDoubt {
  few_depths,            // figure: share of the keypoints with a depth, of a pair those with a match
  no_disparity,          // stereo; share of the matches at the same place of both images, in the same row
  rows_differ,           // stereo; median distance of the rows of matched keypoints, sigmas of a keypoint
  depth_too_near,        // RGB-D; metres, the depth that a tenth of the keypoints are nearer than
  no_relief,             // RGB-D; the range of the middle eight tenths of all depths, by the median depth
  depth_against_motion,  // DepthAgainstMotion::error()
  depth_against_map,     // DepthAgainstMap::error
  depth_displaced,       // RGB-D; OutlineFit::ratio()
  outlines_fit_nowhere,  // RGB-D; OutlineAnswers::fit()
  depth_frozen,          // RGB-D; the number of equal depth images in a row, of other images (FrozenDepth)
  images_torn,           // any camera; the number of torn frames in a row (torn_image.h)
};
constexpr size_t kSensorDoubts = 11;
std::string_view name(SensorDoubt doubt);

struct SensorWarning {
  SensorDoubt doubt = SensorDoubt::few_depths;
  double figure = 0;
  int64_t frame = 0;  // the frame at which it was noticed
};
// Returns what was seen, with the figure, and the likely causes.
std::string describe(const SensorWarning& warning, Sensor sensor);

class SensorMonitor {
 public:
  explicit SensorMonitor(Sensor sensor) : sensor_(sensor) {}

  // The keypoints wanted of a frame. Many more than usual are worse ones, of which fewer have a match.
  enum class Budget { usual, doubled };

  // `row_error`: Frontend::row_error() of a stereo pair.
  void add_frame(int64_t frame, const Features& features, double row_error, Budget budget = Budget::usual);
  void add_comparison(int64_t frame, const DepthAgainstMotion& comparison);
  // Each frame, with the pinhole camera of its features and the noise of depth that was given; it does something only
  // in the first five seconds, until there were five answers, while motion contradicts depth, or while the map is on
  // probation. Then frames are compared as well, at most five in a second, each in 5 to 30 ms: a slow camera makes few
  // key frames, and where all is known none is made whose comparison could end the doubt.
  // Returns true while the last three answers say that depth is right up to its scale.
  bool add_view(int64_t frame, Timestamp stamp, FeaturesPtr features, const Pinhole& camera);
  // Each frame of a depth camera.
  // Outlines are compared where depth is registered to the image alone.
  void add_images(int64_t frame, ImageView<const uint8_t> image, ImageView<const float> depth,
                  const DepthRegistration& registration = {});
  void add_outlines(int64_t frame, const OutlineFit& fit);
  // For each frame FrameDoubts::depth_contradiction.
  void add_map_comparison(int64_t frame, double contradiction);
  // For each frame FrameDoubts::map_on_probation.
  enum class MapTrust { usual, on_probation };
  void add_map_trust(MapTrust trust) { comparisons_.trust = trust; }
  // For each frame FrameDoubts::torn.
  enum class Rows { in_place, displaced };
  void add_rows(int64_t frame, Rows rows);
  // True while poses are not to be relied on: any doubt but a wrong scale, few depths of a depth camera, and depth that
  // contradicts the map or torn images, for which tracking itself calls poses tentative.
  bool doubts() const;
  // True while depth contradicts the images.
  bool doubts_depth() const {
    return holds(SensorDoubt::depth_against_motion) || holds(SensorDoubt::depth_displaced) ||
           holds(SensorDoubt::outlines_fit_nowhere) || holds(SensorDoubt::depth_frozen);
  }
  // True once depth has contradicted the images or the map. It stays so: every key frame is compared from then on.
  bool suspects_depth() const;
  // The warnings since the last call: one of each kind, the first time.
  std::vector<SensorWarning> take_warnings() { return std::exchange(fresh_, {}); }

 private:
  // Figures of the last frames of one kind, for their median.
  template <size_t kSize>
  struct Window {
    std::array<double, kSize> values{};
    size_t count = 0;

    void add(double value) { values[count++ % kSize] = value; }
    double median(size_t last) const {
      std::array<double, kSize> sorted{};
      for (size_t k = 0; k < last; ++k) sorted[k] = values[(count + kSize - 1 - k) % kSize];
      const auto end = sorted.begin() + static_cast<ptrdiff_t>(last),
                 middle = sorted.begin() + static_cast<ptrdiff_t>(last / 2);
      std::nth_element(sorted.begin(), middle, end);
      return *middle;
    }
    bool full() const { return count >= kSize; }
  };
  static constexpr size_t kFrames = 20, kComparisons = 5;

  bool holds(SensorDoubt doubt) const { return wrong_[static_cast<size_t>(doubt)]; }
  void add_share(int64_t frame, double share);
  void add_disparities(int64_t frame, const Features& features, double row_error);
  void add_depths(int64_t frame);
  void forget_share();
  void forget_depths();
  void forget_outlines();
  void judge(SensorDoubt doubt, bool is_wrong, double figure, int64_t frame);

  const Sensor sensor_;
  Window<kFrames> share_;
  // A pair has the first two, a depth camera the others.
  struct DepthFigures {
    Window<kFrames> zero, rows, near, relief;
  };
  DepthFigures depth_figures_;
  struct ComparedFrames {
    MotionDepthCheck check = {};
    std::optional<Timestamp> last = {}, begun = {};
    int agreeing = 0;  // answers in a row
  };
  struct Comparisons {
    Window<kComparisons> error, spread;
    ComparedFrames of_frames;
    MapTrust trust = MapTrust::usual;
  };
  Comparisons comparisons_;
  struct Silence {
    size_t share = 0, depths = 0;
  };
  Silence silence_;  // frames in a row that say nothing of it
  struct InARow {
    int contradictions = 0;  // frames whose depth contradicts the map
    int torn = 0;            // frames
  };
  InARow in_a_row_;
  struct DepthImages {
    FrozenDepth frozen;
    DepthOutlines outlines;
    OutlineAnswers answers;
  };
  DepthImages depth_images_;
  std::vector<double> depths_;  // work space
  std::array<bool, kSensorDoubts> wrong_{}, told_{};
  std::vector<SensorWarning> fresh_;
};

}  // namespace covis
