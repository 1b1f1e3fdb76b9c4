// SPDX-License-Identifier: Apache-2.0
// Relocalisation by the truth: maps the first frames of an RGB-D recording, then places each of the others on its own,
// from nothing, and tells recall and error beside how much of each frame's view the first ones had seen.
//   relocalisation_bench RECORDING CAMERA.yaml FRAMES_TO_MAP [NAME=VALUE …]
// Seen: of the frame's depth, put where the truth says, the share that one mapping frame sees too (in its image, not
// hidden, by 5 % of the depth). The map is put into the
// truth's world by the mean over the mapping frames' poses.
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "covis/core/fields.h"
#include "covis/core/time.h"
#include "covis/io/sequence.h"
#include "covis/slam/system.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {
namespace {

constexpr int kGrid = 20;          // pixels between the depths that are looked at
constexpr int kEvery = 5;          // mapping frames looked at
constexpr double kCosine = 0.94;  // between the rays of both cameras to what both see

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

int run(const char* path, const char* camera_file, int to_map, const std::vector<std::string>& settings) {
  auto sequence = io::open_sequence(path, {.sensor = Sensor::rgbd, .camera_file = camera_file});
  const auto vocabulary = Vocabulary::load(COVIS_SOURCE_DIR "/vocabulary/default.covis-voc");
  if (!sequence || !vocabulary) {
    std::fprintf(stderr, "%s\n", (sequence ? vocabulary.error() : sequence.error()).message.c_str());
    return 1;
  }
  const auto truth = io::load_truth(**sequence);
  if (!truth) return std::fprintf(stderr, "%s\n", truth.error().message.c_str()), 1;
  std::map<Timestamp, SE3> T_wc_of;
  for (const auto& pose : *truth) T_wc_of.emplace(pose.stamp, pose.T_wc);
  const auto true_pose = [&](Timestamp stamp) {
    auto at = T_wc_of.lower_bound(stamp - 5'000'000);
    return at != T_wc_of.end() && at->first < stamp + 5'000'000 ? &at->second : nullptr;
  };

  SystemOptions options;
  for (const std::string& setting : settings) {
    const size_t equals = std::min(setting.find('='), setting.size());
    const std::string value = setting.substr(std::min(equals + 1, setting.size()));
    if (const auto set = set_field(fields(options), setting.substr(0, equals), value); !set)
      return std::fprintf(stderr, "%s\n", set.error().message.c_str()), 1;
  }
  options.sensor = Sensor::rgbd;
  const Camera camera = (*sequence)->camera();
  System system(camera, options, *vocabulary);
  std::vector<View> mapped;
  std::vector<Placed> placed;
  std::vector<double> times;
  SE3 T_truth_map;
  while (true) {
    auto next = (*sequence)->next();
    if (!next) continue;
    if (!*next) break;
    io::Frame& frame = **next;
    const SE3* T_wc = true_pose(frame.stamp);
    if (frame.index < to_map) {
      system.process(input(frame));
      if (T_wc && frame.index % kEvery == 0) mapped.push_back({*T_wc, std::move(frame.depth)});
      continue;
    }
    if (placed.empty()) {
      system.finish();
      std::vector<std::pair<SE3, SE3>> poses;  // estimate and truth
      for (const PoseOfFrame& pose : system.trajectory()) {
        if (const SE3* T = true_pose(pose.stamp)) poses.emplace_back(pose.T_wc, *T);
      }
      if (poses.empty()) return std::fprintf(stderr, "%s: nothing was tracked that has a truth\n", path), 1;
      T_truth_map = mean_motion(poses);
    }
    if (!T_wc) continue;
    Placed& p = placed.emplace_back();
    for (const View& view : mapped) p.seen = std::max(p.seen, share_seen(camera, *T_wc, frame.depth, view));
    const Stopwatch watch;
    const auto found = system.locate(input(frame));
    times.push_back(watch.ms());
    p.found = found.has_value();
    if (!found) continue;
    const SE3 difference = T_wc->inverse() * T_truth_map * *found;
    p.metres = difference.t().norm();
    p.degrees = so3_log(difference.R()).norm() * 180 / std::numbers::pi;
  }
  if (placed.empty()) return std::fprintf(stderr, "%s: no frame is left to be placed\n", path), 1;
  std::puts(
      "| seen before    | frames | found | recall | < 5 cm, 2 deg | error median / 95 % / most | median / 95 % |");
  std::puts("| --- | --- | --- | --- | --- | --- | --- |");
  constexpr std::array<double, 6> kBounds{0, 0.2, 0.4, 0.6, 0.8, 1.0};
  for (size_t k = 0; k + 1 < kBounds.size(); ++k) {
    std::vector<Placed> part;
    std::copy_if(placed.begin(), placed.end(), std::back_inserter(part), [&](const Placed& p) {
      return p.seen >= kBounds[k] && (p.seen < kBounds[k + 1] || kBounds[k + 1] == 1);
    });
    print((std::to_string(static_cast<int>(100 * kBounds[k])) + " to " +
           std::to_string(static_cast<int>(100 * kBounds[k + 1])) + " %")
              .c_str(),
          part);
  }
  print("all", placed);
  std::nth_element(times.begin(), times.begin() + static_cast<ptrdiff_t>(times.size() / 2), times.end());
  std::printf("%.1f ms an image (median)\n", times[times.size() / 2]);
  return 0;
}

}  // namespace
}  // namespace covis

int main(int argc, char** argv) {
  if (argc < 4)
    return std::fprintf(stderr, "usage: relocalisation_bench RECORDING CAMERA.yaml FRAMES_TO_MAP [NAME=VALUE …]\n"), 2;
  return covis::run(argv[1], argv[2], std::atoi(argv[3]), {argv + 4, argv + argc});
}
