// SPDX-License-Identifier: Apache-2.0
// Relocalisation measured against the ground truth: maps the first frames of an RGB-D recording, then locates each of
// the other frames on its own, from scratch, in that map loaded anew (as `covis localize` does), and reports recall and
// error by the share of each frame's view that the first frames had seen.
//   relocalisation_bench RECORDING CAMERA.yaml FRAMES_TO_MAP [NAME=VALUE …]
// The share seen is the largest share of the frame's depth points, placed by the ground truth, that one mapping frame
// sees too: in its image, not hidden (by 5 % of the depth), and along rays at most 20 degrees apart. The map is aligned
// to the ground truth by the mean over the mapping frames' poses; a frame found in another map, begun after a loss,
// counts as not found. As ground truth has errors too, each pose is also compared with a run of all frames. In addition
// the tracked frames of that run and of the mapping run are compared with the ground truth, and so are that run's
// rotations between two frames, which no choice of world changes.
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "covis/core/fields.h"
#include "covis/core/quantile.h"
#include "covis/core/time.h"
#include "covis/io/sequence.h"
#include "covis/map/map_state.h"
#include "covis/slam/system.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {
namespace {

constexpr int kGrid = 20;  // distance of the sampled depths, pixels
constexpr int kEvery = 5;  // interval of the mapping frames compared
// Cosine of 20 degrees, the greatest angle between the two cameras' rays to a common point.
constexpr double kCosine = 0.94;

struct Settings {
  std::string path, camera_file;
  int64_t frames_to_map = 0;
  SystemOptions options;
};

Result<Settings> parse(const std::vector<std::string>& arguments) {
  Settings settings{arguments[0], arguments[1], 0, {}};
  const std::string& number = arguments[2];
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), settings.frames_to_map);
  if (error != std::errc() || end != number.data() + number.size() || settings.frames_to_map < 1)
    return fail("FRAMES_TO_MAP: \"" + number + "\" is not a number of frames, 1 or more");
  const Fields known = fields(settings.options);
  for (size_t i = 3; i < arguments.size(); ++i) {
    const size_t equals = arguments[i].find('=');
    if (equals == std::string::npos) return fail(arguments[i] + ": it must be NAME=VALUE");
    if (const auto set = set_field(known, arguments[i].substr(0, equals), arguments[i].substr(equals + 1)); !set)
      return tl::unexpected(set.error());
  }
  settings.options.sensor = Sensor::rgbd;
  return settings;
}

// Poses by stamp: the true ones, or those of a run.
class Poses {
 public:
  explicit Poses(const Trajectory& poses) {
    for (const auto& pose : poses) T_wc_.emplace(pose.stamp, pose.T_wc);
  }
  // Takes the poses of the run's first map.
  explicit Poses(const System& run) {
    const auto snapshot = run.snapshot();
    for (const PoseOfFrame& pose : snapshot->trajectory) {
      if (pose.submap == snapshot->submaps.front().id) T_wc_.emplace(pose.stamp, pose.T_wc);
    }
  }
  // Returns the pose within 5 ms of the stamp, or nullptr.
  const SE3* at(Timestamp stamp) const {
    constexpr Timestamp kNear = 5'000'000;
    const auto found = T_wc_.lower_bound(stamp - kNear);
    return found != T_wc_.end() && found->first < stamp + kNear ? &found->second : nullptr;
  }
  auto begin() const { return T_wc_.begin(); }
  auto end() const { return T_wc_.end(); }

 private:
  std::map<Timestamp, SE3> T_wc_;
};

struct View {
  SE3 T_wc;
  ImageF depth;
};

System::Input input(const io::Frame& frame) {
  return {.frame = frame.index,
          .stamp = frame.stamp,
          .image = frame.image.view(),
          .right = frame.right.view(),
          .depth = frame.depth.view()};
}

double share_seen(const Camera& camera, const SE3& T_wc, const ImageF& depth, const View& view) {
  const SE3 T_vc = view.T_wc.inverse() * T_wc;
  int all = 0, seen = 0;
  for (int y = kGrid / 2; y < camera.height; y += kGrid) {
    for (int x = kGrid / 2; x < camera.width; x += kGrid) {
      const double z = static_cast<double>(depth(x, y));
      if (!(z > 0)) continue;
      ++all;
      const Eigen::Vector3d p = T_vc * (z * camera.pinhole.unproject(x, y));
      if (p.z() < 0.1) continue;
      const Eigen::Vector2d at = camera.pinhole.project(p);
      if (!(at.x() >= 0 && at.y() >= 0 && at.x() < camera.width - 1 && at.y() < camera.height - 1)) continue;
      const double there =
          static_cast<double>(view.depth(static_cast<int>(at.x() + 0.5), static_cast<int>(at.y() + 0.5)));
      const Eigen::Vector3d from_here = p - T_vc.t();
      const double cosine = p.dot(from_here) / (p.norm() * from_here.norm());
      seen += std::abs(there - p.z()) < 0.05 * p.z() && cosine > kCosine;
    }
  }
  return all > 0 ? static_cast<double>(seen) / all : 0;
}

// Returns the transform from the estimate's world to the ground truth's as the mean over the poses. (The positions of a
// short walk alone would leave the orientation uncertain by degrees.)
SE3 mean_motion(const std::vector<std::pair<SE3, SE3>>& poses) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d estimate = Eigen::Vector3d::Zero(), truth = Eigen::Vector3d::Zero();
  for (const auto& [a, b] : poses) {
    sum += b.R() * a.R().transpose();
    estimate += a.t();
    truth += b.t();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  return SE3(R, Eigen::Vector3d((truth - R * estimate) / static_cast<double>(poses.size())));
}

struct PoseError {
  double metres = 0, degrees = 0;
  bool small() const { return metres < 0.05 && degrees < 2; }
};

// Returns the rotation of camera b in the frame of camera a as a rotation vector, degrees.
Eigen::Vector3d turn(const SE3& a_T_wc, const SE3& b_T_wc) {
  return so3_log(a_T_wc.R().transpose() * b_T_wc.R()) * 180 / std::numbers::pi;
}

PoseError pose_error(const SE3& T_wc, const SE3& right_T_wc) {
  return {(T_wc.t() - right_T_wc.t()).norm(), turn(right_T_wc, T_wc).norm()};
}

void print(const std::vector<PoseError>& errors) {
  std::vector<double> metres, degrees;
  for (const PoseError& e : errors) {
    metres.push_back(e.metres);
    degrees.push_back(e.degrees);
  }
  const auto good = std::count_if(errors.begin(), errors.end(), [](const PoseError& e) { return e.small(); });
  std::printf(" %5ld | %.3f / %.3f / %.3f m, %.2f / %.2f deg |", static_cast<long>(good), quantile(metres, 0.5),
              quantile(metres, 0.95), quantile(metres, 1), quantile(degrees, 0.5), quantile(degrees, 0.95));
}

struct Placed {
  double seen = 0;
  bool found = false;
  PoseError of_truth, of_run;  // errors of a found frame
};

void print(const char* name, const std::vector<Placed>& frames) {
  std::vector<PoseError> of_truth, of_run;
  for (const Placed& frame : frames) {
    if (!frame.found) continue;
    of_truth.push_back(frame.of_truth);
    of_run.push_back(frame.of_run);
  }
  const size_t all = frames.size(), found = of_truth.size();
  std::printf("| %-14s | %5zu | %5zu | %5.1f %% |", name, all, found,
              all ? 100.0 * static_cast<double>(found) / static_cast<double>(all) : 0.0);
  print(of_truth);
  print(of_run);
  std::puts("");
}

// Calls visit(frame) for each readable frame.
template <class Visit>
void for_each_frame(io::Sequence& sequence, Visit&& visit) {
  while (true) {
    auto next = sequence.next();
    if (!next) continue;
    if (!*next) return;
    visit(**next);
  }
}

// Maps all frames; returns the views of some of them at their true poses.
std::vector<View> map_frames(io::Sequence& sequence, const Poses& truth, System& system) {
  std::vector<View> views;
  for_each_frame(sequence, [&](io::Frame& frame) {
    system.process(input(frame));
    const SE3* T_wc = truth.at(frame.stamp);
    if (T_wc && frame.index % kEvery == 0) views.push_back({*T_wc, std::move(frame.depth)});
  });
  system.finish();
  return views;
}

// Returns the transform from a run's world to that of other poses of the same frames.
Result<SE3> to_world_of(const Poses& poses, const Poses& run) {
  std::vector<std::pair<SE3, SE3>> pairs;
  for (const auto& [stamp, T_wc] : run) {
    if (const SE3* other = poses.at(stamp)) pairs.emplace_back(T_wc, *other);
  }
  if (pairs.empty()) return fail("nothing was mapped that has a pose to compare with");
  return mean_motion(pairs);
}

// Returns the errors of a run's tracked frames after alignment to the ground truth.
std::vector<PoseError> tracked_errors(const Poses& truth, const Poses& run, const SE3& T_truth_run) {
  std::vector<PoseError> errors;
  for (const auto& [stamp, T_wc] : run) {
    if (const SE3* right = truth.at(stamp)) errors.push_back(pose_error(T_truth_run * T_wc, *right));
  }
  return errors;
}

// Returns the median ratio of the run's rotation between two frames to the true rotation, for rotations of more than 10
// degrees about the camera's x (pitch), y (yaw) and z (roll). A wrong focal length, of the run or of the ground truth,
// changes only the first two.
std::array<double, 3> turn_ratios(const Poses& truth, const Poses& run) {
  std::vector<std::pair<SE3, SE3>> frames;  // estimated and true pose of each frame
  size_t index = 0;
  for (const auto& [stamp, T_wc] : run) {
    const SE3* right = truth.at(stamp);
    if (right && index++ % kEvery == 0) frames.emplace_back(T_wc, *right);
  }
  std::array<std::vector<double>, 3> ratios;
  for (size_t a = 0; a < frames.size(); ++a) {
    for (size_t b = a + 1; b < frames.size(); ++b) {
      const Eigen::Vector3d right = turn(frames[a].second, frames[b].second);
      Eigen::Index axis = 0;
      const double most = right.cwiseAbs().maxCoeff(&axis);
      if (right.norm() < 10 || most < 0.9 * right.norm()) continue;
      const double angle = turn(frames[a].first, frames[b].first).norm();
      ratios[static_cast<size_t>(axis)].push_back(angle / right.norm());
    }
  }
  return {quantile(ratios[0], 0.5), quantile(ratios[1], 0.5), quantile(ratios[2], 0.5)};
}

// Poses to compare with, and the transform to their world.
struct Reference {
  const Poses* poses;
  SE3 T_reference_map;
};

struct Placing {
  std::vector<Placed> frames;
  std::vector<double> times;                  // ms
  std::vector<PoseError> mapped, run_of_all;  // errors of the tracked frames of both runs against the ground truth
  std::array<double, 3> turn_ratios{};
};

Placing place(io::Sequence& sequence, const std::vector<View>& mapped, const Reference& truth, const Reference& run,
              System& system) {
  Placing placing;
  const Camera camera = sequence.camera();
  const uint32_t submap = system.submaps().front().id;
  for_each_frame(sequence, [&](const io::Frame& frame) {
    const SE3 *T_wc = truth.poses->at(frame.stamp), *run_T_wc = run.poses->at(frame.stamp);
    if (!T_wc || !run_T_wc) return;
    Placed& p = placing.frames.emplace_back();
    for (const View& view : mapped) p.seen = std::max(p.seen, share_seen(camera, *T_wc, frame.depth, view));
    const Stopwatch watch;
    const auto found = system.locate(input(frame));
    placing.times.push_back(watch.ms());
    p.found = found && found->submap == submap;
    if (!p.found) return;
    p.of_truth = pose_error(truth.T_reference_map * found->T_wc, *T_wc);
    p.of_run = pose_error(run.T_reference_map * found->T_wc, *run_T_wc);
  });
  return placing;
}

void print_tracked(const char* name, const std::vector<PoseError>& errors) {
  std::printf("%s, as tracked, against the truth: of %zu", name, errors.size());
  print(errors);
  std::puts("");
}

void print(const Placing& placing) {
  std::puts("Errors: frames within 5 cm and 2 degrees; median / 95 % / most, median / 95 %.");
  std::puts("| seen before    | frames | found | recall | of truth | | of a run of all frames | |");
  std::puts("| --- | --- | --- | --- | --- | --- | --- | --- |");
  constexpr std::array<int, 6> kBounds{0, 20, 40, 60, 80, 100};  // percent
  for (size_t k = 0; k + 1 < kBounds.size(); ++k) {
    const double from = kBounds[k] / 100.0, to = kBounds[k + 1] / 100.0;
    std::vector<Placed> seen;
    std::copy_if(placing.frames.begin(), placing.frames.end(), std::back_inserter(seen),
                 [&](const Placed& p) { return p.seen >= from && (p.seen < to || to == 1); });
    print((std::to_string(kBounds[k]) + " to " + std::to_string(kBounds[k + 1]) + " %").c_str(), seen);
  }
  print("all", placing.frames);
  print_tracked("mapping frames", placing.mapped);
  print_tracked("run of all frames", placing.run_of_all);
  const auto& [pitch, yaw, roll] = placing.turn_ratios;
  std::printf("run of all frames, its turns over the truth's (0: too small): pitch %.2f, yaw %.2f, roll %.2f\n", pitch,
              yaw, roll);
  std::printf("%.1f ms an image (median)\n", quantile(placing.times, 0.5));
}

Result<Placing> run(const Settings& settings) {
  const auto open = [&](int64_t from, int64_t count) {
    io::SequenceOptions reading{.sensor = Sensor::rgbd, .camera_file = settings.camera_file};
    reading.first = from;
    reading.count = count;
    return io::open_sequence(settings.path, reading);
  };
  const auto first = open(0, settings.frames_to_map);
  if (!first) return tl::unexpected(first.error());
  const auto rest = open(settings.frames_to_map, -1);
  if (!rest) return tl::unexpected(rest.error());
  const auto all = open(0, -1);
  if (!all) return tl::unexpected(all.error());
  const auto vocabulary = Vocabulary::load(COVIS_SOURCE_DIR "/vocabulary/default.covis-voc");
  if (!vocabulary) return tl::unexpected(vocabulary.error());
  const auto true_poses = io::load_truth(**first);
  if (!true_poses) return tl::unexpected(true_poses.error());
  const Poses truth(*true_poses);

  const Camera camera = (*first)->camera();
  System mapping(camera, settings.options, *vocabulary), mapping_all(camera, settings.options, *vocabulary);
  const std::vector<View> mapped = map_frames(**first, truth, mapping);
  map_frames(**all, truth, mapping_all);
  const Poses mapping_poses(mapping), run_poses(mapping_all);
  const auto T_truth_map = to_world_of(truth, mapping_poses), T_run_map = to_world_of(run_poses, mapping_poses),
             T_truth_run = to_world_of(truth, run_poses);
  for (const auto* world : {&T_truth_map, &T_run_map, &T_truth_run}) {
    if (!*world) return tl::unexpected(world->error());
  }
  auto map = Map::from_state(mapping.map_state());
  if (!map) return tl::unexpected(map.error());
  SystemOptions options = settings.options;
  options.localize = true;
  System system(camera, options, *vocabulary);
  if (const auto set = system.set_map(std::move(*map), camera); !set) return tl::unexpected(set.error());
  Placing placing = place(**rest, mapped, {&truth, *T_truth_map}, {&run_poses, *T_run_map}, system);
  if (placing.frames.empty()) return fail(settings.path + ": no frame with a truth is left to be placed");
  placing.mapped = tracked_errors(truth, mapping_poses, *T_truth_map);
  placing.run_of_all = tracked_errors(truth, run_poses, *T_truth_run);
  placing.turn_ratios = turn_ratios(truth, run_poses);
  return placing;
}

}  // namespace
}  // namespace covis

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: relocalisation_bench RECORDING CAMERA.yaml FRAMES_TO_MAP [NAME=VALUE …]\n");
    return 2;
  }
  const auto settings = covis::parse({argv + 1, argv + argc});
  const auto placing = settings ? covis::run(*settings) : tl::unexpected(settings.error());
  if (!placing) {
    std::fprintf(stderr, "%s\n", placing.error().message.c_str());
    return 1;
  }
  covis::print(*placing);
}
