// SPDX-License-Identifier: Apache-2.0
// Compares matching by words (the vocabulary's direct index) with the methods that Covis uses: comparison of all
// descriptors (loops and, with other thresholds, the reference key frame and relocalisation) and epipolar search (new
// points). Uses pairs of rendered views with exact depth, some time apart; a match is right when it lies within 3
// pixels x scale of the true position of the point.
//   matching_bench             counters, means over the pairs: right matches, the share of right ones among the matches
#include <benchmark/benchmark.h>

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "covis/features/frontend.h"
#include "covis/matching/descriptor_match.h"
#include "covis/matching/epipolar_match.h"
#include "covis/vocabulary/vocabulary.h"
#include "synth/synth.h"

namespace covis {
namespace {

struct Pair {
  FeaturesPtr a, b;
  DirectIndex index_a, index_b;
  SE3 T_ba;
  Pinhole camera;
};

const Vocabulary& vocabulary() {
  static const auto loaded = Vocabulary::load(COVIS_SOURCE_DIR "/vocabulary/default.covis-voc").value();
  return *loaded;
}

// Returns pairs of views `apart` seconds from each other, from worlds with a seed not used to train the vocabulary.
const std::vector<Pair>& pairs(double apart) {
  static std::map<double, std::vector<Pair>> made;
  std::vector<Pair>& all = made[apart];
  if (!all.empty()) return all;
  for (const std::string world : {"room", "desk", "corridor", "street"}) {
    SynthOptions options;
    options.world = world;
    options.sensor = "rgbd";
    options.seed = 301;
    options.noise = 4;
    options.exposure = 0.3;
    Synth synth = std::move(Synth::create(options).value());
    Frontend frontend(synth.camera(), {}, Sensor::rgbd);
    const auto view = [&](int i) {
      ImageU8 image;
      ImageF depth;
      synth.render(i, image, nullptr, &depth);
      return frontend.rgbd(image.view(), depth.view());
    };
    for (int i = 5; i < 250; i += 40) {
      const int j = i + static_cast<int>(std::lround(apart / to_seconds(synth.stamp(1) - synth.stamp(0))));
      Pair& pair = all.emplace_back();
      pair.camera = synth.camera().pinhole;
      pair.a = view(i);
      pair.b = view(j);
      pair.index_a = vocabulary().direct_index(pair.a->descriptor);
      pair.index_b = vocabulary().direct_index(pair.b->descriptor);
      pair.T_ba = synth.T_wc(j).inverse() * synth.T_wc(i);
      pair.camera = synth.camera().pinhole;
    }
  }
  return all;
}

bool is_right(const Pair& pair, const FeatureMatch& match) {
  const Features &a = *pair.a, &b = *pair.b;
  const auto i = static_cast<size_t>(match.a), j = static_cast<size_t>(match.b);
  const Eigen::Vector3d p = pair.T_ba * (static_cast<double>(a.depth[i]) * pair.camera.unproject(a.x[i], a.y[i]));
  if (p.z() <= 0) return false;
  const Eigen::Vector2d at = pair.camera.project(p);
  return std::hypot(at.x() - b.x[j], at.y() - b.y[j]) < 3 * b.pyramid->scale[b.level[j]];
}

// Mutual nearest neighbours among the features under the same node, with the same thresholds as match_descriptors.
std::vector<FeatureMatch> match_by_words(const Pair& pair, const std::vector<uint8_t>& use,
                                         const DescriptorMatchOptions& options) {
  const DirectIndex &wa = pair.index_a, &wb = pair.index_b;
  std::vector<FeatureMatch> matches;
  for (size_t ka = 0, kb = 0; ka < wa.node.size() && kb < wb.node.size();) {
    if (wa.node[ka] != wb.node[kb]) {
      ++(wa.node[ka] < wb.node[kb] ? ka : kb);
      continue;
    }
    std::vector<int> owner(wb.offset[kb + 1] - wb.offset[kb], -1), least(owner.size(), 257);
    const size_t first = matches.size();
    for (uint32_t m = wa.offset[ka]; m < wa.offset[ka + 1]; ++m) {
      const uint32_t i = wa.feature[m];
      if (!use[i]) continue;
      int best = 257, second = 257;
      uint32_t best_at = 0;
      for (uint32_t n = 0; n < owner.size(); ++n) {
        const int d = hamming(pair.a->descriptor[i], pair.b->descriptor[wb.feature[wb.offset[kb] + n]]);
        if (d < least[n]) {
          least[n] = d;
          owner[n] = static_cast<int>(i);
        }
        if (d < best) {
          second = best;
          best = d;
          best_at = n;
        } else if (d < second) {
          second = d;
        }
      }
      if (best <= options.max_distance && static_cast<float>(best) < options.ratio * static_cast<float>(second))
        matches.push_back({static_cast<int32_t>(i), static_cast<int32_t>(best_at)});
    }
    size_t kept = first;
    for (size_t m = first; m < matches.size(); ++m) {
      const auto at = static_cast<size_t>(matches[m].b);
      if (owner[at] != matches[m].a) continue;
      matches[kept++] = {matches[m].a, static_cast<int32_t>(wb.feature[wb.offset[kb] + at])};
    }
    matches.resize(kept);
    ++ka;
    ++kb;
  }
  keep_consistent_rotations(*pair.a, *pair.b, matches);
  return matches;
}

template <class Match>
void measure(benchmark::State& state, Match&& match) {
  const std::vector<Pair>& all = pairs(static_cast<double>(state.range(0)) / 10);
  double right = 0, found = 0;
  std::vector<std::vector<uint8_t>> use;
  for (const Pair& pair : all) {
    std::vector<uint8_t>& with_depth = use.emplace_back();
    for (int i = 0; i < pair.a->size(); ++i) with_depth.push_back(pair.a->has_depth(i));
    for (const FeatureMatch& m : match(pair, with_depth)) {
      ++found;
      right += is_right(pair, m);
    }
  }
  size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(match(all[next], use[next]));
    next = (next + 1) % all.size();
  }
  state.counters["right"] = right / static_cast<double>(all.size());
  state.counters["share_right"] = right / found;
}

// Thresholds of loop closing. The reference key frame uses 0.7, relocalisation 0.9 and a distance of 64.
constexpr DescriptorMatchOptions kGates{.max_distance = kHammingLow, .ratio = 0.75f};

void every_descriptor(benchmark::State& state) {
  measure(state, [](const Pair& pair, const std::vector<uint8_t>& use) {
    return match_descriptors(*pair.a, use, *pair.b, {}, kGates);
  });
}

void by_words(benchmark::State& state) {
  measure(state, [](const Pair& pair, const std::vector<uint8_t>& use) { return match_by_words(pair, use, kGates); });
}

// The method for new points, which uses the known pose.
void epipolar(benchmark::State& state) {
  measure(state, [](const Pair& pair, const std::vector<uint8_t>& use) {
    return match_epipolar(pair.camera, *pair.a, use, *pair.b, {}, pair.T_ba, {});
  });
}

// Measures the cost of building the direct index for each frame.
void making_the_index(benchmark::State& state) {
  const std::vector<Pair>& all = pairs(0.5);
  size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(vocabulary().direct_index(all[next].b->descriptor));
    next = (next + 1) % all.size();
  }
}

BENCHMARK(every_descriptor)->ArgName("apart_ds")->Arg(5)->Arg(10)->Arg(20)->Unit(benchmark::kMicrosecond);
BENCHMARK(by_words)->ArgName("apart_ds")->Arg(5)->Arg(10)->Arg(20)->Unit(benchmark::kMicrosecond);
BENCHMARK(epipolar)->ArgName("apart_ds")->Arg(5)->Arg(10)->Arg(20)->Unit(benchmark::kMicrosecond);
BENCHMARK(making_the_index)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace covis
