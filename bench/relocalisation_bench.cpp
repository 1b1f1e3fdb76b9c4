// SPDX-License-Identifier: Apache-2.0
// Relocalisation by the truth: maps the first frames of an RGB-D recording, then places each of the others on its own,
// from nothing, in that map loaded anew (as `covis localize` does), and tells recall and error beside how much of each
// frame's view the first ones had seen.
//   relocalisation_bench RECORDING CAMERA.yaml FRAMES_TO_MAP [NAME=VALUE …]
// Seen: of the frame's depth, put where the truth says, the largest share that one mapping frame sees too: in its
// image, not hidden (by 5 % of the depth), and along rays at most 20 degrees apart. The map is put into the truth's
// world by the mean over the mapping frames' poses; a frame found in another map, begun after a loss, counts as not
// found.
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
#include "covis/core/time.h"
#include "covis/io/sequence.h"
#include "covis/map/map_state.h"
#include "covis/slam/system.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {
namespace {

constexpr int kGrid = 20;         // pixels between the depths that are looked at
constexpr int kEvery = 5;         // mapping frames looked at
constexpr double kCosine = 0.94;  // of 20 degrees, between the rays of both cameras to what both see

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

// True poses by their stamps.
class Truth {
 public:
  explicit Truth(const Trajectory& poses) {
    for (const auto& pose : poses) T_wc_.emplace(pose.stamp, pose.T_wc);
  }
  // Within 5 ms; nullptr: there is none.
  const SE3* at(Timestamp stamp) const {
    constexpr Timestamp kNear = 5'000'000;
    const auto found = T_wc_.lower_bound(stamp - kNear);
    return found != T_wc_.end() && found->first < stamp + kNear ? &found->second : nullptr;
  }

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

// From the estimate's world to the truth's: the mean over poses. (The places of a short walk alone would leave the
// orientation open by degrees.)
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

struct Placed {
  double seen = 0;
  bool found = false;
  double metres = 0, degrees = 0;
};

void print(const char* name, std::vector<Placed> frames) {
  const size_t all = frames.size();
  std::erase_if(frames, [](const Placed& p) { return !p.found; });
  const auto good =
      std::count_if(frames.begin(), frames.end(), [](const Placed& p) { return p.metres < 0.05 && p.degrees < 2; });
  const auto quantile = [&](double Placed::*of, double q) {
    if (frames.empty()) return 0.0;
    std::sort(frames.begin(), frames.end(), [&](const Placed& a, const Placed& b) { return a.*of < b.*of; });
    return frames[static_cast<size_t>(q * static_cast<double>(frames.size() - 1))].*of;
  };
  std::printf("| %-14s | %5zu | %5zu | %5.1f %% | %5ld | %.3f / %.3f / %.3f m | %.2f / %.2f deg |\n", name, all,
              frames.size(), all ? 100.0 * static_cast<double>(frames.size()) / static_cast<double>(all) : 0.0,
              static_cast<long>(good), quantile(&Placed::metres, 0.5), quantile(&Placed::metres, 0.95),
              quantile(&Placed::metres, 1), quantile(&Placed::degrees, 0.5), quantile(&Placed::degrees, 0.95));
}

// Calls visit(frame) for each frame that can be read.
template <class Visit>
void for_each_frame(io::Sequence& sequence, Visit&& visit) {
  while (true) {
    auto next = sequence.next();
    if (!next) continue;
    if (!*next) return;
    visit(**next);
  }
}

// Maps them all; returns what some of them saw, from where they truly were.
std::vector<View> map_frames(io::Sequence& sequence, const Truth& truth, System& system) {
  std::vector<View> views;
  for_each_frame(sequence, [&](io::Frame& frame) {
    system.process(input(frame));
    const SE3* T_wc = truth.at(frame.stamp);
    if (T_wc && frame.index % kEvery == 0) views.push_back({*T_wc, std::move(frame.depth)});
  });
  system.finish();
  return views;
}

// From the first map's world to the truth's.
Result<SE3> to_truth(const System& system, const Truth& truth) {
  std::vector<std::pair<SE3, SE3>> poses;  // estimate and truth
  for (const PoseOfFrame& pose : system.trajectory()) {
    const SE3* T_wc = truth.at(pose.stamp);
    if (T_wc && pose.map == 0) poses.emplace_back(pose.T_wc, *T_wc);
  }
  if (poses.empty()) return fail("nothing was mapped that has a truth");
  return mean_motion(poses);
}

struct Placing {
  std::vector<Placed> frames;
  std::vector<double> times;  // ms
};

Placing place(io::Sequence& sequence, const Truth& truth, const std::vector<View>& mapped, const SE3& T_truth_map,
              System& system) {
  Placing placing;
  const Camera camera = sequence.camera();
  const uint32_t part = system.maps().front().part;
  for_each_frame(sequence, [&](const io::Frame& frame) {
    const SE3* T_wc = truth.at(frame.stamp);
    if (!T_wc) return;
    Placed& p = placing.frames.emplace_back();
    for (const View& view : mapped) p.seen = std::max(p.seen, share_seen(camera, *T_wc, frame.depth, view));
    const Stopwatch watch;
    const auto found = system.locate(input(frame));
    placing.times.push_back(watch.ms());
    p.found = found && found->part == part;
    if (!p.found) return;
    const SE3 difference = T_wc->inverse() * T_truth_map * found->T_wc;
    p.metres = difference.t().norm();
    p.degrees = so3_log(difference.R()).norm() * 180 / std::numbers::pi;
  });
  return placing;
}

void print(Placing placing) {
  std::puts(
      "| seen before    | frames | found | recall | < 5 cm, 2 deg | error median / 95 % / most | median / 95 % |");
  std::puts("| --- | --- | --- | --- | --- | --- | --- |");
  constexpr std::array<int, 6> kBounds{0, 20, 40, 60, 80, 100};  // percent
  for (size_t k = 0; k + 1 < kBounds.size(); ++k) {
    const double from = kBounds[k] / 100.0, to = kBounds[k + 1] / 100.0;
    std::vector<Placed> part;
    std::copy_if(placing.frames.begin(), placing.frames.end(), std::back_inserter(part),
                 [&](const Placed& p) { return p.seen >= from && (p.seen < to || to == 1); });
    print((std::to_string(kBounds[k]) + " to " + std::to_string(kBounds[k + 1]) + " %").c_str(), part);
  }
  print("all", placing.frames);
  const auto middle = placing.times.begin() + static_cast<ptrdiff_t>(placing.times.size() / 2);
  std::nth_element(placing.times.begin(), middle, placing.times.end());
  std::printf("%.1f ms an image (median)\n", *middle);
}

Result<Placing> run(const Settings& settings) {
  io::SequenceOptions reading{.sensor = Sensor::rgbd, .camera_file = settings.camera_file};
  reading.count = settings.frames_to_map;
  const auto first = io::open_sequence(settings.path, reading);
  if (!first) return tl::unexpected(first.error());
  reading.first = settings.frames_to_map;
  reading.count = -1;
  const auto rest = io::open_sequence(settings.path, reading);
  if (!rest) return tl::unexpected(rest.error());
  const auto vocabulary = Vocabulary::load(COVIS_SOURCE_DIR "/vocabulary/default.covis-voc");
  if (!vocabulary) return tl::unexpected(vocabulary.error());
  const auto poses = io::load_truth(**first);
  if (!poses) return tl::unexpected(poses.error());
  const Truth truth(*poses);

  const Camera camera = (*first)->camera();
  System mapping(camera, settings.options, *vocabulary);
  const std::vector<View> mapped = map_frames(**first, truth, mapping);
  const auto T_truth_map = to_truth(mapping, truth);
  if (!T_truth_map) return tl::unexpected(T_truth_map.error());
  auto map = Map::from_state(mapping.map().read()->state());
  if (!map) return tl::unexpected(map.error());
  SystemOptions options = settings.options;
  options.localize = true;
  System system(camera, options, *vocabulary);
  if (const auto set = system.set_map(std::move(*map), camera); !set) return tl::unexpected(set.error());
  Placing placing = place(**rest, truth, mapped, *T_truth_map, system);
  if (placing.frames.empty()) return fail(settings.path + ": no frame with a truth is left to be placed");
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
