// SPDX-License-Identifier: Apache-2.0
// The database against an oracle that looks at every key frame, on maps that grow and shrink.
#include "covis/map/key_frame_database.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "covis/core/random.h"
#include "covis/features/test_features.h"
#include "covis/map/map.h"

namespace covis {
namespace {

std::shared_ptr<const Words> random_words(Random& random, int place) {
  // Words near the place's own, so that places are alike within and differ between.
  std::map<uint32_t, float> drawn;
  for (int k = 0; k < 40; ++k) {
    const uint32_t word =
        random.below(4) == 0 ? random.below(500) : static_cast<uint32_t>(place * 40) + random.below(60);
    drawn[word] = static_cast<float>(random.uniform(0.2, 1));
  }
  float sum = 0;
  for (const auto& [word, weight] : drawn) sum += weight;
  auto words = std::make_shared<Words>();
  for (const auto& [word, weight] : drawn) words->words.push_back({word, weight / sum});
  return words;
}

// algorithms.md §2, word for word, over all key frames.
std::vector<KeyFrameId> oracle(const Map& map, const Words& words, const std::vector<KeyFrameId>& excluded,
                               double min_score) {
  std::vector<std::pair<KeyFrameId, int>> sharing;
  int most = 0;
  std::vector<KeyFrameId> all;
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame&) { all.push_back(id); });
  std::sort(all.begin(), all.end());
  for (const KeyFrameId& id : all) {
    if (std::find(excluded.begin(), excluded.end(), id) != excluded.end()) continue;
    int common = 0;
    for (const WordWeight& a : words.words) {
      for (const WordWeight& b : map.at(id).words->words) common += a.word == b.word;
    }
    if (common > 0) sharing.emplace_back(id, common);
    most = std::max(most, common);
  }
  std::map<KeyFrameId, double> score;
  for (const auto& [id, common] : sharing) {
    if (common < 0.8 * most) continue;
    const double s = WeightsByWord(words.words).score(map.at(id).words->words);
    if (s >= min_score) score[id] = s;
  }
  std::vector<std::pair<double, KeyFrameId>> groups;
  double best_sum = 0;
  for (const auto& [id, s] : score) {
    double sum = s, best_score = s;
    KeyFrameId best = id;
    for (const Neighbour& n : map.best_neighbours(id, 10)) {
      if (!score.contains(n.key_frame)) continue;
      sum += score[n.key_frame];
      if (score[n.key_frame] > best_score) {
        best_score = score[n.key_frame];
        best = n.key_frame;
      }
    }
    groups.emplace_back(sum, best);
    best_sum = std::max(best_sum, sum);
  }
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<KeyFrameId> result;
  for (const auto& [sum, id] : groups) {
    if (sum >= 0.75 * best_sum && std::find(result.begin(), result.end(), id) == result.end()) result.push_back(id);
  }
  return result;
}

TEST(KeyFrameDatabase, QueriesEqualAnExhaustiveOracle) {
  Random random(3);
  Map map;
  const FeaturesPtr shared_features = random_features(random, 200, 2);
  std::vector<KeyFrameId> ids;
  size_t answers = 0;
  for (int step = 0; step < 300; ++step) {
    if (ids.size() > 20 && random.below(4) == 0) {
      const size_t k = 1 + random.below(static_cast<uint32_t>(ids.size() - 1));
      ASSERT_TRUE(map.erase_key_frame(ids[k]));
      ids.erase(ids.begin() + static_cast<ptrdiff_t>(k));
    } else {
      const KeyFrameId id = map.add_key_frame(step, step, SE3(), shared_features);
      map.set_words(id, random_words(random, static_cast<int>(random.below(10))));
      if (!ids.empty()) {  // 20 points shared with the newest
        for (uint32_t k = 0; k < 20; ++k) {
          const uint32_t feature = (step % 2 == 0 ? 0 : 100) + 2 * k;
          const MapPointId point = map.add_point({0, 0, 5}, id, feature);
          if (point.valid()) map.add_observation(point, ids.back(), feature);
        }
      }
      map.attach_to_tree(id);
      ids.push_back(id);
    }
    ASSERT_EQ(map.check(), "");
    const auto words = random_words(random, static_cast<int>(random.below(10)));
    std::vector<KeyFrameId> excluded;
    for (const KeyFrameId& id : ids) {
      if (random.below(5) == 0) excluded.push_back(id);
    }
    std::sort(excluded.begin(), excluded.end());
    const double min_score = random.below(2) ? 0 : random.uniform(0, 0.4);
    std::vector<KeyFrameId> found;
    for (const auto& c : map.database().query(
             map, *words, [&](KeyFrameId id) { return std::binary_search(excluded.begin(), excluded.end(), id); },
             min_score)) {
      found.push_back(c.key_frame);
      EXPECT_GE(c.score, min_score);
    }
    EXPECT_EQ(found, oracle(map, *words, excluded, min_score)) << "step " << step;
    answers += found.size();
  }
  EXPECT_GT(answers, 300u);
}

TEST(Map, PosesRelativeToErasedKeyFramesFollowTheScale) {
  Random random(1);
  Map map;
  const FeaturesPtr f = random_features(random, 10, 2);
  const auto at = [](double x) { return SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-x, 0, 0)); };
  const KeyFrameId a = map.add_key_frame(0, 0, at(0), f), b = map.add_key_frame(1, 1, at(1), f);
  map.attach_to_tree(b);
  const KeyFrameId c = map.add_key_frame(2, 2, at(3), f);
  map.attach_to_tree(c);
  const KeyFrameId d = map.add_key_frame(3, 3, at(6), f);
  map.attach_to_tree(d);
  ASSERT_EQ(map.at(d).parent, c);
  // Everything grows by 2, then d goes, everything grows by 3, c goes, and by 5.
  const auto grow = [&](double growth) {
    for (const KeyFrameId& id : map.key_frames()) {
      const SE3& T = map.at(id).T_cw;
      map.correct_pose(id, SE3(T.R(), Eigen::Vector3d(growth * T.t())), growth);
    }
  };
  grow(2);
  ASSERT_TRUE(map.erase_key_frame(d));
  grow(3);
  ASSERT_TRUE(map.erase_key_frame(c));
  grow(5);
  for (const auto& [id, x] : {std::pair{d, 6.0}, {c, 3.0}, {b, 1.0}, {a, 0.0}}) {
    const auto resolved = map.resolve(id);
    ASSERT_TRUE(resolved);
    EXPECT_NEAR((resolved->T_ar * map.at(resolved->key_frame).T_cw).centre().x(), 30 * x, 1e-9);
    EXPECT_NEAR(resolved->scale, 30, 1e-12);
  }
}

}  // namespace
}  // namespace covis
