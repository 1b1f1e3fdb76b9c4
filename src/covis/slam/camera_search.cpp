// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/camera_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "covis/core/log.h"
#include "covis/map/anchors.h"
#include "covis/matching/patch_alignment.h"
#include "covis/slam/lens_answers.h"
#include "covis/slam/system.h"

namespace covis {
namespace {

// How much of the recording is tracked: until there are so many frames since the map began, or so many key frames.
struct Piece {
  int64_t frames = 0;
  size_t key_frames = 0;  // that mapping made; some are culled again
};
constexpr Piece kShort{300, 60}, kLong{1000, 100}, kClosing{1000, 200};
constexpr int64_t kLatestBegin = 3000;  // frames without a map, after which there will be none

// Focal lengths over the longer side of the image: 96, 75, 58 and 42 degrees.
constexpr std::array<double, 4> kGuesses{0.45, 0.65, 0.9, 1.3};

// Logarithms of the focal length.
constexpr double kNear = 0.04;         // change after which longer pieces are tracked
constexpr double kAside = 0.06;        // how far to both sides it is looked at then
constexpr double kLittleAside = 0.01;  // the same at last, when matches are aligned
constexpr double kAlike = 4.0 / 3;     // aligned places of neighbours err alike: times the deviations of others
// At last a key frame is made wherever the view changed a little (KeyFrameOptions), and all are kept: each shows the
// lens anew.
constexpr double kLittleParallax = 0.05, kMuchLeft = 0.9, kNotRedundant = 1;
constexpr double kSettledChange = 0.02;  // change after which it is taken for found
constexpr double kSure = 0.04;           // standard deviation up to which it is known
constexpr int kMostRounds = 6;
constexpr size_t kLeastKeyFrames = 8;
constexpr size_t kLeastObservers = 3;

constexpr const char* kNoMap =
    "no map could be made of its frames with any focal length that was tried: the camera must move sideways before a "
    "scene with texture";
constexpr const char* kNotTold =
    "the camera's motion does not tell its focal length: it must move sideways and turn, not only go ahead or turn in "
    "place";

constexpr double kPixels = 520'000;  // images of more than that are made smaller

// Images are made smaller by whole factors: the mean of blocks.
class Shrinker {
 public:
  Shrinker(int width, int height)
      : factor_(std::max(1, static_cast<int>(std::lround(std::sqrt(width * static_cast<double>(height) / kPixels))))),
        small_(width / factor_, height / factor_) {}

  int factor() const { return factor_; }
  int width() const { return small_.width(); }
  int height() const { return small_.height(); }

  ImageView<const uint8_t> operator()(ImageView<const uint8_t> image) {
    if (factor_ == 1) return image;
    const int count = factor_ * factor_;
    for (int y = 0; y < small_.height(); ++y) {
      for (int x = 0; x < small_.width(); ++x) {
        int sum = count / 2;
        for (int v = 0; v < factor_; ++v) {
          const uint8_t* row = image.row(y * factor_ + v) + static_cast<ptrdiff_t>(x) * factor_;
          for (int u = 0; u < factor_; ++u) sum += row[u];
        }
        small_(x, y) = static_cast<uint8_t>(sum / count);
      }
    }
    return small_.view();
  }

 private:
  int factor_;
  ImageU8 small_;
};

// The largest submap as a problem of poses in the order of time, points seen often enough, and pixels of the images.
BundleProblem problem_of(const Map& map, const Pinhole& camera) {
  BundleProblem problem;
  problem.camera = camera;
  const std::vector<Submap> submaps = map.submaps();
  const auto largest = std::max_element(submaps.begin(), submaps.end(),
                                        [](const Submap& a, const Submap& b) { return a.key_frames < b.key_frames; });
  if (largest == submaps.end()) return problem;
  const float closer = aligned_weight(map.camera());
  std::unordered_map<KeyFrameId, int32_t> pose_of;
  for (const KeyFrameId& id : map.key_frames(largest->id)) {
    pose_of.emplace(id, static_cast<int32_t>(problem.poses.size()));
    problem.poses.push_back(map.at(id).T_cw);
    problem.fixed.push_back(0);
  }
  map.for_each_point([&](MapPointId, const MapPoint& point) {
    if (point.observations.size() < kLeastObservers) return;
    if (!pose_of.contains(point.observations.front().key_frame)) return;
    const AlignedObservations aligned(map, point);
    for (const Observation& seen : point.observations) {
      const KeyFrame& key_frame = map.at(seen.key_frame);
      const Features& features = *key_frame.features;
      const uint32_t i = seen.feature;
      const float weight = aligned.contain(key_frame, i) ? closer : 1;
      problem.observations.push_back({.pose = pose_of.at(seen.key_frame),
                                      .point = static_cast<int32_t>(problem.points.size()),
                                      .u = features.image_x()[i],
                                      .v = features.image_y()[i],
                                      .inv_sigma2 = weight * features.pyramid->inv_sigma2[features.level[i]]});
    }
    problem.points.push_back(point.position_w);
  });
  return problem;
}

// The result of tracking with one lens.
struct Tracked {
  BundleProblem problem;  // its map; without poses where there are too few key frames
  int64_t frames = 0;     // number of those tracked
};

class CameraSearch {
 public:
  CameraSearch(int width, int height, const RecordingPlayer& play, const SystemOptions& options,
               const std::function<void(const std::string&)>& tell, const std::atomic<int>* interrupt)
      : shrink_(width, height), play_(play), options_(options), tell_(tell), interrupt_(interrupt) {
    options_.sensor = Sensor::monocular;
    options_.mapper.refine_focal = options_.mapper.refine_distortion = false;
    options_.realtime = options_.localize = false;
    options_.tracker.readout = 0;  // other wrong figures look like one, and lenses are compared by pixels as they are
    // With a wrong focal length matches don't fit as closely as aligned ones should.
    aligning_ = std::exchange(options_.orb.patches, false);
  }

  // The lens is that of the shrunken images.
  Result<SettledLens> find() {
    auto best = first_guess();
    if (!best) return tl::unexpected(best.error());
    Lens lens = believed(*best)->lens;
    for (int i = 0; i < kMostRounds && std::abs(std::log(lens.focal / best->given)) > kNear; ++i) {
      best = answer(lens, kShort);
      if (!best) return tl::unexpected(best.error());
      if (!believed(*best)) return fail(kNoMap);
      lens = believed(*best)->lens;
      say(*best);
    }
    SettledLens settled{.lens = lens, .sigma = {}};
    for (int i = 0; i < kMostRounds; ++i) {
      const auto next = between(settled.lens, kAside, kLong);
      if (!next) return next;
      settled = *next;
      if (settled.change < kSettledChange && !settled.repeats) return sharpened(settled);
    }
    return settled;
  }

  // Number of key frames of the last maps.
  size_t key_frames() const { return std::max(answers_.end()[-1].key_frames, answers_.end()[-2].key_frames); }

  Camera camera(const Lens& lens) const {
    Camera camera{.width = shrink_.width(), .height = shrink_.height(), .pinhole = {}};
    camera.pinhole = {.fx = lens.focal,
                      .fy = lens.focal,
                      .cx = 0.5 * (camera.width - 1) + lens.cx,
                      .cy = 0.5 * (camera.height - 1) + lens.cy};
    if (lens.k1 != 0 || lens.k2 != 0) camera.distortion = Distortion::brown_conrady;
    camera.coefficients[0] = lens.k1;
    camera.coefficients[1] = lens.k2;
    return camera;
  }

  int factor() const { return shrink_.factor(); }

 private:
  double longer_side() const { return std::max(shrink_.width(), shrink_.height()); }

  // Near the lens that was found matches can be aligned, and tell it more closely.
  Result<SettledLens> sharpened(const SettledLens& settled) {
    if (!aligning_) return settled;
    options_.orb.patches = true;
    options_.tracker.key_frame.key_frame_parallax_mono = kLittleParallax;
    options_.tracker.key_frame.key_frame_ratio_mono = kMuchLeft;
    options_.mapper.cull_redundancy = kNotRedundant;
    std::vector<LensAnswer> before = std::exchange(answers_, {});
    auto sharper = between(settled.lens, kLittleAside, kClosing, settled.fall);
    if (interrupt_ && *interrupt_) return fail("interrupted");
    if (sharper && sharper->change < kSettledChange) return sharper;
    answers_ = std::move(before);
    return settled;
  }

  // The recording is tracked with a shorter and with a longer focal length than that of `lens`.
  Result<SettledLens> between(const Lens& lens, double apart, const Piece& piece,
                              std::optional<double> fall = std::nullopt) {
    for (const double aside : {-apart, apart}) {
      Lens given = lens;
      given.focal *= std::exp(aside);
      auto made = answer(given, piece);
      if (!made) return tl::unexpected(made.error());
      if (!believed(*made)) return fail(kNotTold);
      say(*made);
      answers_.push_back(std::move(*made));
    }
    const auto settled = settle(answers_, lens, longer_side(), fall);
    if (!settled) return fail(kNotTold);
    return *settled;
  }

  // The guess whose map fits best, where few frames tracked count against it.
  Result<LensAnswer> first_guess() {
    std::optional<LensAnswer> best;
    const auto misfit = [](const LensAnswer& a) { return believed(a)->variance / static_cast<double>(a.tracked); };
    for (const double focal : kGuesses) {
      const auto made = answer({focal * longer_side()}, kShort);
      if (!made) return made;
      if (believed(*made) && (!best || misfit(*made) < misfit(*best))) best = *made;
    }
    if (!best) return fail(kNoMap);
    say(*best);
    return *best;
  }

  // The answer has nothing to believe where no map came about.
  Result<LensAnswer> answer(Lens lens, const Piece& piece) {
    lens.focal = std::clamp(lens.focal, kLeastFocal * longer_side(), kGreatestFocal * longer_side());
    auto tracked = track(lens, piece);
    if (!tracked) return tl::unexpected(tracked.error());
    LensAnswer made = answer_of(tracked->problem, lens, longer_side(), interrupt_);
    if (interrupt_ && *interrupt_) return fail("interrupted");
    made.tracked = tracked->frames;
    if (options_.orb.patches) scale_deviations(made, kAlike);
    return made;
  }

  Result<Tracked> track(const Lens& lens, const Piece& piece) {
    const LogPause pause;
    Tracked made;
    System system(camera(lens), options_);
    int64_t frame = 0, since_begin = 0;
    size_t key_frames = 0;  // those that mapping reported: what the map holds at a moment depends on its pace
    const Result<void> played = play_([&](ImageView<const uint8_t> image, Timestamp stamp) {
      if (interrupt_ && *interrupt_) return false;
      const FrameReport report =
          system.process({.frame = frame, .stamp = stamp, .image = shrink_(image), .right = {}, .depth = {}});
      ++frame;
      made.frames += report.track.state == TrackingState::tracking;
      key_frames += report.mapping.size();
      since_begin += since_begin > 0 || report.track.state != TrackingState::not_initialised;
      return since_begin < piece.frames && key_frames < piece.key_frames && (since_begin > 0 || frame < kLatestBegin);
    });
    if (!played) return tl::unexpected(played.error());
    if (interrupt_ && *interrupt_) return fail("interrupted");
    system.finish();
    made.problem = problem_of(*system.map().read(), camera({lens.focal}).pinhole);
    if (made.problem.poses.size() < kLeastKeyFrames) made.problem = {};
    return made;
  }

  void say(const LensAnswer& answer) const {
    const auto focal = std::lround(believed(answer)->lens.focal * factor());
    tell_("finding the camera: " + std::to_string(answer.key_frames) + " key frames tell a focal length of " +
          std::to_string(focal) + " pixels");
  }

  Shrinker shrink_;
  const RecordingPlayer& play_;
  SystemOptions options_;
  bool aligning_ = false;  // at last, where the lens is nearly known
  const std::function<void(const std::string&)>& tell_;
  const std::atomic<int>* interrupt_;
  std::vector<LensAnswer> answers_;  // results of long pieces
};

}  // namespace

Result<FoundCamera> find_camera(int width, int height, const RecordingPlayer& play, const SystemOptions& options,
                                const std::function<void(const std::string&)>& tell,
                                const std::atomic<int>* interrupt) {
  CameraSearch search(width, height, play, options, tell, interrupt);
  const Result<SettledLens> settled = search.find();
  if (!settled) return tl::unexpected(settled.error());
  FoundCamera found;
  const Lens& lens = settled->lens;
  const double factor = search.factor();
  found.sigma = settled->sigma;
  found.sigma.focal = std::hypot(settled->sigma.focal, settled->change);
  found.sigma.cx *= factor;
  found.sigma.cy *= factor;
  found.key_frames = search.key_frames();
  if (settled->repeats || !(found.sigma.focal < kSure)) return fail(kNotTold);
  found.camera = search.camera(lens);
  found.camera.width = width;
  found.camera.height = height;
  Pinhole& pinhole = found.camera.pinhole;
  pinhole.fx = pinhole.fy = factor * lens.focal;
  pinhole.cx = factor * (pinhole.cx + 0.5) - 0.5;  // a pixel of the small images is a block of the large ones
  pinhole.cy = factor * (pinhole.cy + 0.5) - 0.5;
  return found;
}

}  // namespace covis
