// SPDX-License-Identifier: Apache-2.0
// The speed of a vocabulary, and its recall of places: corridors and streets not used for training are rendered for two
// rounds, and each frame of the second round queries for the most similar frame of the first (docs/vocabulary.md).
//   COVIS_VOCABULARY=FILE vocabulary_bench     default: the vocabulary that ships with Covis
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "covis/features/frontend.h"
#include "covis/vocabulary/vocabulary.h"
#include "synth/synth.h"

namespace covis {
namespace {

std::string vocabulary_file() {
  const char* named = std::getenv("COVIS_VOCABULARY");
  return named != nullptr ? named : COVIS_SOURCE_DIR "/vocabulary/default.covis-voc";
}

std::shared_ptr<const Vocabulary> vocabulary(benchmark::State& state) {
  auto loaded = Vocabulary::load(vocabulary_file());
  if (loaded) return *loaded;
  state.SkipWithError(loaded.error().message.c_str());
  return nullptr;
}

struct Visit {
  AlignedVector<Descriptor> descriptors;
  Eigen::Vector3d position;
};
// Two rounds of a loop; frames before second[0] belong to the first round.
struct Place {
  std::vector<Visit> first, second;
};

Place render(const std::string& world, int seed) {
  SynthOptions options;
  options.world = world;
  options.seed = seed;
  options.sensor = "mono";
  options.fps = world == "street" ? 5 : 2;
  options.frames = world == "street" ? 480 : 260;
  options.noise = 4;
  options.exposure = 0.3;
  options.blur = 10;
  auto synth = Synth::create(options);
  Place place;
  if (!synth) return place;
  Frontend frontend(synth->camera(), {}, Sensor::monocular);
  ImageU8 image;
  bool away = false, back = false;
  const Eigen::Vector3d start = synth->T_wc(0).t();
  for (int i = 0; i < synth->frames(); ++i) {
    synth->render(i, image, nullptr, nullptr);
    const Eigen::Vector3d position = synth->T_wc(i).t();
    away |= (position - start).norm() > 10;
    back |= away && (position - start).norm() < 1.5;
    (back ? place.second : place.first).push_back({frontend.monocular(image.view())->descriptor, position});
    if (place.second.size() == place.first.size()) break;
  }
  return place;
}

const std::vector<Place>& places() {
  static const std::vector<Place> all = [] {
    std::vector<Place> made;
    for (const int seed : {301, 302, 303}) {
      made.push_back(render("corridor", seed));
      made.push_back(render("street", seed));
    }
    return made;
  }();
  return all;
}

struct Entry {
  std::vector<WordWeight> words;
  const Place* place;
  Eigen::Vector3d position;
};

struct Best {
  double near = 0, far = 0;  // greatest scores within 2 m, and beyond 10 m or in another place
  double all = 0;
};

Best query(const std::vector<Entry>& map, const Entry& asked) {
  Best best;
  const WeightsByWord weights(asked.words);
  for (const Entry& entry : map) {
    const double score = weights.score(entry.words);
    const double distance = entry.place == asked.place ? (entry.position - asked.position).norm() : 1e9;
    best.all = std::max(best.all, score);
    if (distance <= 2) best.near = std::max(best.near, score);
    if (distance > 10) best.far = std::max(best.far, score);
  }
  return best;
}

// Returns the words of every `step`-th feature of an image.
std::vector<WordWeight> words_of(const Vocabulary& vocabulary, const Visit& visit, size_t step) {
  AlignedVector<Descriptor> some;
  for (size_t i = 0; i < visit.descriptors.size(); i += step) some.push_back(visit.descriptors[i]);
  return vocabulary.transform(some).words;
}

// Arguments: the number of places in a map (all places are queried, in maps of that many); the number of features used
// out of 1000.
void BM_Recall(benchmark::State& state) {
  const auto voc = vocabulary(state);
  if (!voc) return;
  const auto size = static_cast<size_t>(state.range(0)), step = static_cast<size_t>(1000 / state.range(1));
  std::vector<double> margins;
  size_t found = 0, images = 0;
  for (auto _ : state) {
    for (size_t begin = 0; begin + size <= places().size(); begin += size) {
      std::vector<Entry> map;
      for (size_t p = begin; p < begin + size; ++p) {
        for (const Visit& visit : places()[p].first) {
          map.push_back({words_of(*voc, visit, step), &places()[p], visit.position});
        }
      }
      images = std::max(images, map.size());
      for (size_t p = begin; p < begin + size; ++p) {
        for (const Visit& visit : places()[p].second) {
          const Best best = query(map, {words_of(*voc, visit, step), &places()[p], visit.position});
          found += best.near > 0 && best.near >= best.all ? 1 : 0;
          margins.push_back(best.near / std::max(best.far, 1e-6));
        }
      }
    }
  }
  std::sort(margins.begin(), margins.end());
  state.counters["images"] = static_cast<double>(images);
  state.counters["queries"] = static_cast<double>(margins.size());
  state.counters["recall"] = static_cast<double>(found) / static_cast<double>(std::max<size_t>(1, margins.size()));
  if (!margins.empty()) {
    state.counters["margin_median"] = margins[margins.size() / 2];
    state.counters["margin_5pc"] = margins[margins.size() / 20];
  }
}
BENCHMARK(BM_Recall)->ArgsProduct({{1, 6}, {1000, 200, 50}})->Iterations(1)->Unit(benchmark::kMillisecond);

void BM_Load(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(Vocabulary::load(vocabulary_file()));
}
BENCHMARK(BM_Load)->Unit(benchmark::kMillisecond);

void BM_Transform(benchmark::State& state) {
  const auto voc = vocabulary(state);
  if (!voc) return;
  const Place& place = places().front();
  size_t i = 0, features = 0;
  for (auto _ : state) {
    const AlignedVector<Descriptor>& descriptors = place.first[i++ % place.first.size()].descriptors;
    benchmark::DoNotOptimize(voc->transform(descriptors));
    features += descriptors.size();
  }
  state.counters["features"] = static_cast<double>(features) / static_cast<double>(state.iterations());
}
BENCHMARK(BM_Transform)->Unit(benchmark::kMillisecond);

void BM_Score(benchmark::State& state) {
  const auto voc = vocabulary(state);
  if (!voc) return;
  const Words a = voc->transform(places().front().first[0].descriptors);
  const Words b = voc->transform(places().front().first[1].descriptors);
  const WeightsByWord weights(a.words);
  for (auto _ : state) benchmark::DoNotOptimize(weights.score(b.words));
}
BENCHMARK(BM_Score)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace covis
