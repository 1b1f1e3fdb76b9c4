// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/local_adjustment.h"

#include <algorithm>
#include <utility>

#include "covis/mapping/map_problem.h"

namespace covis {
namespace {

// The key frames that share points with those of `frames` and are not among them, with the points shared in all, most
// first.
std::vector<Neighbour> holders_of(const Map& map, const std::vector<KeyFrameId>& frames) {
  std::vector<Neighbour> holders;
  for (const KeyFrameId& id : frames) {
    for (const Neighbour& n : map.at(id).shared) {
      if (std::find(frames.begin(), frames.end(), n.key_frame) == frames.end()) holders.push_back(n);
    }
  }
  std::sort(holders.begin(), holders.end(),
            [](const Neighbour& x, const Neighbour& y) { return x.key_frame < y.key_frame; });
  std::vector<Neighbour> summed;
  for (const Neighbour& n : holders) {
    if (!summed.empty() && summed.back().key_frame == n.key_frame) {
      summed.back().weight += n.weight;
    } else {
      summed.push_back(n);
    }
  }
  std::stable_sort(summed.begin(), summed.end(),
                   [](const Neighbour& x, const Neighbour& y) { return x.weight > y.weight; });
  return summed;
}

}  // namespace

LocalWindow window_around(const Map& map, std::vector<KeyFrameId> moving, int fixed) {
  LocalWindow window{std::move(moving), 0};
  window.moving = window.key_frames.size();
  std::vector<Neighbour> holders = holders_of(map, window.key_frames);
  if (holders.size() > static_cast<size_t>(fixed)) holders.resize(static_cast<size_t>(fixed));
  for (const Neighbour& n : holders) window.key_frames.push_back(n.key_frame);
  return window;
}

LocalWindow local_window(const Map& map, KeyFrameId current, int moving, int fixed) {
  std::vector<KeyFrameId> key_frames{current};
  for (const Neighbour& n : map.best_neighbours(current, moving - 1)) key_frames.push_back(n.key_frame);
  return window_around(map, std::move(key_frames), fixed);
}

AdjustmentReport adjust_locally(SharedMap& shared, KeyFrameId current, const MapperOptions& options,
                                BundleAdjuster& adjuster, DepthNoiseTracker* depth_noise,
                                const std::atomic<bool>* interrupt) {
  AdjustmentReport report;
  MapProblem local;
  {
    const auto map = shared.read();
    const LocalWindow window = local_window(*map, current, options.ba_key_frames, options.ba_fixed_key_frames);
    local.gather(*map, window.key_frames, window.moving);
    report.key_frames = static_cast<int>(window.moving);
    report.points = static_cast<int>(local.points.size());
    report.observations = static_cast<int>(local.problem.observations.size());
  }
  // With no other key frame to hold it the window would drift as a whole: the one that shares fewest points with the
  // new key frame stays.
  BundleProblem& problem = local.problem;
  if (std::find(problem.fixed.begin(), problem.fixed.end(), 1) == problem.fixed.end()) problem.fixed.back() = 1;

  BundleSummary summary = adjuster.solve(problem, {.iterations = options.ba_iterations_first, .interrupt = interrupt});
  bool adjusted = summary.ok;
  if (summary.ok && !summary.interrupted && options.ba_iterations_second > 0) {
    classify_observations(problem);
    summary =
        adjuster.solve(problem, {.iterations = options.ba_iterations_second, .robust = false, .interrupt = interrupt});
    adjusted = summary.ok || summary.interrupted;  // the first one's result holds
  }
  report.interrupted = summary.interrupted;
  if (!adjusted) return report;
  classify_observations(problem);
  {
    MapEdit edit(shared);
    local.commit(edit);
  }
  if (depth_noise && !summary.interrupted) depth_noise->learn(shared, problem);
  return report;
}

}  // namespace covis
