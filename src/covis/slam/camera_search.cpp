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
#include "covis/optimization/lens_adjustment.h"
#include "covis/slam/system.h"

namespace covis {
namespace {

// How much of the recording is tracked: until there are so many frames since the map began, or so many key frames.
struct Piece {
  int64_t frames = 0;
  size_t key_frames = 0;  // that mapping made; some are culled again
};
constexpr Piece kShort{300, 60}, kLong{1000, 100};
constexpr int64_t kLatestBegin = 3000;  // frames without a map, after which there will be none

// Focal lengths over the longer side of the image: 96, 75, 58 and 42 degrees.
constexpr std::array<double, 4> kGuesses{0.45, 0.65, 0.9, 1.3};
constexpr double kLeastFocal = 0.25, kGreatestFocal = 4;  // over the longer side: 127 and 14 degrees
constexpr double kGreatestK1 = 0.5;
constexpr double kUsualK1 = 0.3;  // standard deviation of k1 over lenses

// Logarithms of the focal length.
constexpr double kNear = 0.04;           // change after which k1 is let go
constexpr double kAside = 0.06;          // how far to both sides it is looked at then
constexpr double kFarthest = 0.25;       // greatest step from there
constexpr double kSettledChange = 0.02;  // change after which it is taken for found
constexpr double kSure = 0.04;           // standard deviation up to which it is known
constexpr double kLeastFall = 0.3;       // share of an error that a map must take away, or it repeats what it was given
constexpr double kNearby = 0.15;         // results so far away are laid on one line
constexpr double kNoise = 0.01;          // how much two results differ that should be equal
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
BundleProblem problem_of(const Map& map) {
  BundleProblem problem;
  problem.camera = map.camera();
  const std::vector<Submap> submaps = map.submaps();
  const auto largest = std::max_element(submaps.begin(), submaps.end(),
                                        [](const Submap& a, const Submap& b) { return a.key_frames < b.key_frames; });
  if (largest == submaps.end()) return problem;
  std::unordered_map<KeyFrameId, int32_t> pose_of;
  for (const KeyFrameId& id : map.key_frames(largest->id)) {
    pose_of.emplace(id, static_cast<int32_t>(problem.poses.size()));
    problem.poses.push_back(map.at(id).T_cw);
    problem.fixed.push_back(0);
  }
  map.for_each_point([&](MapPointId, const MapPoint& point) {
    if (point.observations.size() < kLeastObservers) return;
    if (!pose_of.contains(point.observations.front().key_frame)) return;
    for (const Observation& seen : point.observations) {
      const Features& features = *map.at(seen.key_frame).features;
      const uint32_t i = seen.feature;
      problem.observations.push_back({.pose = pose_of.at(seen.key_frame),
                                      .point = static_cast<int32_t>(problem.points.size()),
                                      .u = features.image_x()[i],
                                      .v = features.image_y()[i],
                                      .inv_sigma2 = features.pyramid->inv_sigma2[features.level[i]]});
    }
    problem.points.push_back(point.position_w);
  });
  return problem;
}

// The result of tracking with one lens and adjusting it with the map.
struct Round {
  LensAdjustment found;
  int64_t tracked = 0;
  size_t key_frames = 0;
  double change = 0;  // change of the focal length's logarithm
};

// The focal length that the recording gave back when it was tracked with `given`: logarithms.
struct Answer {
  double given = 0;
  double sigma = 0;  // the greater standard deviation of the focal length
  Round round;
};

// The lens that tracking with it, and adjusting it with the map, gives back.
struct Settled {
  Lens lens;
  double focal_sigma = 0;  // standard deviation of the focal length, as a share of it
  double k1_sigma = 0;
  double change = 1;  // change of the focal length's logarithm, to the one before
  size_t key_frames = 0;
  bool repeats = true;  // the recording says what it was tracked with
};

class CameraSearch {
 public:
  CameraSearch(int width, int height, const RecordingPlayer& play, const SystemOptions& options,
               const std::function<void(const std::string&)>& tell, const std::atomic<int>* interrupt)
      : shrink_(width, height), play_(play), options_(options), tell_(tell), interrupt_(interrupt) {
    options_.sensor = Sensor::monocular;
    options_.mapper.refine_focal = false;
    options_.realtime = options_.localize = false;
  }

  // The lens is that of the shrunken images.
  Result<Settled> find() {
    auto best = first_guess();
    if (!best) return tl::unexpected(best.error());
    for (int i = 0; i < kMostRounds && std::abs(best->change) > kNear; ++i) {
      best = round_with_map({bounded(best->found.lens).focal, 0}, 0, kShort);
      if (!best) return tl::unexpected(best.error());
      say(*best);
    }
    Settled settled{.lens = {bounded(best->found.lens).focal, 0}};
    for (int i = 0; i < kMostRounds; ++i) {
      const auto next = between(settled.lens);
      if (!next) return next;
      settled = *next;
      if (settled.change < kSettledChange && !settled.repeats) break;
    }
    return settled;
  }

  Camera camera(const Lens& lens) const {
    Camera camera{.width = shrink_.width(), .height = shrink_.height(), .pinhole = {}};
    camera.pinhole = {
        .fx = lens.focal, .fy = lens.focal, .cx = 0.5 * (camera.width - 1), .cy = 0.5 * (camera.height - 1)};
    if (lens.k1 != 0) camera.distortion = Distortion::brown_conrady;
    camera.coefficients[0] = lens.k1;
    return camera;
  }

  int factor() const { return shrink_.factor(); }

 private:
  double longer_side() const { return std::max(shrink_.width(), shrink_.height()); }

  Lens bounded(Lens lens) const {
    lens.focal = std::clamp(lens.focal, kLeastFocal * longer_side(), kGreatestFocal * longer_side());
    lens.k1 = std::clamp(lens.k1, -kGreatestK1, kGreatestK1);
    return lens;
  }

  // The map remembers the focal length that it was tracked with: of one that is too short a part of the error stays.
  // So the recording is tracked with a shorter and with a longer one than `lens`, and the one that would give itself is
  // found on the line through these results and earlier ones nearby.
  Result<Settled> between(const Lens& lens) {
    for (const double aside : {-kAside, kAside}) {
      const Lens given = bounded({lens.focal * std::exp(aside), lens.k1});
      const auto made = round_with_map(given, kUsualK1, kLong);
      if (!made) return tl::unexpected(made.error());
      say(*made);
      answers_.push_back({std::log(given.focal), std::max(made->found.sigma, made->found.scatter), *made});
    }
    return on_the_line(lens);
  }

  // A line by weighted least squares through the changes over what was given: it crosses zero at the result. The less
  // steeply it falls, the less is known.
  Settled on_the_line(const Lens& lens) const {
    const double centre = std::log(lens.focal);
    // The weighted mean of a quantity of the results nearby.
    const auto mean = [&](const auto& quantity) {
      double sum = 0, weights = 0;
      for (const Answer& answer : answers_) {
        if (std::abs(answer.given - centre) > kNearby) continue;
        const double weight = 1 / (answer.sigma * answer.sigma + kNoise * kNoise);
        sum += weight * quantity(answer);
        weights += weight;
      }
      return sum / weights;
    };
    const double given = mean([](const Answer& answer) { return answer.given; });
    const double change = mean([](const Answer& answer) { return answer.round.change; });
    const auto product = [&](const Answer& answer) { return (answer.given - given) * (answer.round.change - change); };
    const double spread = mean([&](const Answer& answer) { return std::pow(answer.given - given, 2); });
    const double measured_fall = -mean(product) / std::max(spread, 1e-9);
    const double fall = std::clamp(measured_fall, kLeastFall, 1.0);
    const double step = given + change / fall - centre;
    const auto nearby = std::count_if(answers_.begin(), answers_.end(),
                                      [&](const Answer& answer) { return std::abs(answer.given - centre) <= kNearby; });
    const double misfit = mean([&](const Answer& answer) {
      return std::pow(answer.round.change - change + fall * (answer.given - given), 2);
    });
    const double systematic = mean([](const Answer& answer) { return answer.sigma * answer.sigma; });
    Settled settled;
    settled.lens = bounded({lens.focal * std::exp(std::clamp(step, -kFarthest, kFarthest)),
                            mean([](const Answer& answer) { return answer.round.found.lens.k1; })});
    settled.change = std::abs(step);
    settled.repeats = measured_fall < kLeastFall;
    // The results' own deviations have one cause, the recording; what they miss the line by is each one's own.
    settled.focal_sigma = std::sqrt(systematic + misfit / static_cast<double>(std::max<long>(nearby - 2, 1))) / fall;
    settled.k1_sigma = std::sqrt(mean([](const Answer& answer) { return std::pow(answer.round.found.k1_sigma, 2); }));
    settled.key_frames = std::max(answers_.end()[-1].round.key_frames, answers_.end()[-2].round.key_frames);
    return settled;
  }

  // The guess whose map fits best, where few frames tracked count against it.
  Result<Round> first_guess() {
    std::optional<Round> best;
    const auto misfit = [](const Round& made) { return made.found.variance / static_cast<double>(made.tracked); };
    for (const double guess : kGuesses) {
      const auto made = round({guess * longer_side(), 0}, 0, kShort);
      if (!made) return made;
      if (made->found.ok && (!best || misfit(*made) < misfit(*best))) best = *made;
    }
    if (!best) return fail(kNoMap);
    say(*best);
    return *best;
  }

  Result<Round> round_with_map(const Lens& lens, double usual_k1, const Piece& piece) {
    auto made = round(lens, usual_k1, piece);
    if (made && !made->found.ok) return fail(kNoMap);
    return made;
  }

  // The adjustment is not ok where no map came about.
  Result<Round> round(const Lens& lens, double usual_k1, const Piece& piece) {
    const LogPause pause;
    Round made;
    System system(camera(lens), options_);
    int64_t frame = 0, since_begin = 0;
    size_t key_frames = 0;  // those that mapping reported: what the map holds at a moment depends on its pace
    const Result<void> played = play_([&](ImageView<const uint8_t> image, Timestamp stamp) {
      if (interrupt_ && *interrupt_) return false;
      const FrameReport report =
          system.process({.frame = frame, .stamp = stamp, .image = shrink_(image), .right = {}, .depth = {}});
      ++frame;
      made.tracked += report.track.state == TrackingState::tracking;
      key_frames += report.mapping.size();
      since_begin += since_begin > 0 || report.track.state != TrackingState::not_initialised;
      return since_begin < piece.frames && key_frames < piece.key_frames && (since_begin > 0 || frame < kLatestBegin);
    });
    if (!played) return tl::unexpected(played.error());
    if (interrupt_ && *interrupt_) return fail("interrupted");
    system.finish();
    BundleProblem problem = problem_of(*system.map().read());
    made.key_frames = problem.poses.size();
    if (made.key_frames < kLeastKeyFrames) return made;
    made.found = adjust_lens(problem, lens, {.usual_k1 = usual_k1});
    if (made.found.ok) made.change = std::log(bounded(made.found.lens).focal / lens.focal);
    return made;
  }

  void say(const Round& made) const {
    const auto focal = std::lround(made.found.lens.focal * factor());
    tell_("finding the camera: " + std::to_string(made.key_frames) + " key frames tell a focal length of " +
          std::to_string(focal) + " pixels");
  }

  Shrinker shrink_;
  const RecordingPlayer& play_;
  SystemOptions options_;
  const std::function<void(const std::string&)>& tell_;
  const std::atomic<int>* interrupt_;
  std::vector<Answer> answers_;  // results of long pieces
};

}  // namespace

Result<FoundCamera> find_camera(int width, int height, const RecordingPlayer& play, const SystemOptions& options,
                                const std::function<void(const std::string&)>& tell,
                                const std::atomic<int>* interrupt) {
  CameraSearch search(width, height, play, options, tell, interrupt);
  const Result<Settled> settled = search.find();
  if (!settled) return tl::unexpected(settled.error());
  FoundCamera found;
  found.focal_sigma = std::hypot(settled->focal_sigma, settled->change);
  found.k1_sigma = settled->k1_sigma;
  found.key_frames = settled->key_frames;
  if (settled->repeats || !(found.focal_sigma < kSure)) return fail(kNotTold);
  found.camera = search.camera({settled->lens.focal * search.factor(), settled->lens.k1});
  found.camera.width = width;
  found.camera.height = height;
  found.camera.pinhole.cx = 0.5 * (width - 1);
  found.camera.pinhole.cy = 0.5 * (height - 1);
  return found;
}

}  // namespace covis
