// SPDX-License-Identifier: Apache-2.0
#include "covis/vocabulary/vocabulary.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "covis/core/test_targets.h"
#include "covis/vocabulary/test_vocabulary.h"
#include "covis/vocabulary/vocabulary_text.h"

namespace covis {
namespace {

class WordsTest : public testing::Test {
 protected:
  void SetUp() override {
    vocabulary_ = train_made(images_, 5, 4);
    const TemporaryFolder folder;
    ASSERT_TRUE(vocabulary_->save_text(folder / "tree.txt"));
    auto text = parse_vocabulary_text(read_file(folder / "tree.txt"));
    ASSERT_TRUE(text);
    tree_ = std::move(text->nodes);
  }

  struct Walked {
    uint32_t node;    // the word's, numbered as in the text
    uint32_t direct;  // its ancestor at the level of the direct index
  };
  // Looks at every node on each level.
  Walked walk(const Descriptor& descriptor) const {
    Walked at{0, 0};
    for (int level = 1;; ++level) {
      uint32_t best = 0;
      for (uint32_t n = 1; n <= tree_.size(); ++n) {
        if (tree_[n - 1].parent != at.node) continue;
        const int distance = hamming(descriptor, tree_[n - 1].descriptor);
        if (best == 0 || distance < hamming(descriptor, tree_[best - 1].descriptor)) best = n;
      }
      if (best == 0) return at;
      at.node = best;
      if (level <= kDirectIndexLevel) at.direct = best;
    }
  }

  MadeImages images_{7, 30, 150, 60};
  std::shared_ptr<const Vocabulary> vocabulary_;
  std::vector<VocabularyNode> tree_;
};

TEST_F(WordsTest, AreThoseOfAnExhaustiveWalk) {
  const MadeImages others(8, 10, 80, 60);  // not those it was trained from
  for (size_t i = 0; i < 10; ++i) {
    const auto image = i % 2 == 0 ? others.image(i) : images_.image(i);
    std::map<uint32_t, double> weights;  // by the word's node; words rise with their nodes
    std::map<uint32_t, std::vector<uint32_t>> direct;
    double sum = 0;
    for (uint32_t f = 0; f < image.size(); ++f) {
      const Walked walked = walk(image[f]);
      weights[walked.node] += static_cast<double>(tree_[walked.node - 1].weight);
      sum += static_cast<double>(tree_[walked.node - 1].weight);
      direct[walked.direct].push_back(f);
    }
    const Words words = vocabulary_->transform(image);
    std::erase_if(weights, [](const auto& entry) { return entry.second == 0; });
    ASSERT_EQ(words.words.size(), weights.size());
    size_t k = 0;
    for (const auto& [node, weight] : weights) {
      EXPECT_NEAR(static_cast<double>(words.words[k].weight), weight / sum, 1e-6);
      EXPECT_FLOAT_EQ(vocabulary_->weight(words.words[k].word), tree_[node - 1].weight);
      ++k;
    }
    const DirectIndex index = vocabulary_->direct_index(image);
    ASSERT_EQ(index.node.size(), direct.size());
    ASSERT_EQ(index.offset.size(), direct.size() + 1);
    k = 0;
    for (const auto& [node, features] : direct) {
      EXPECT_EQ(index.node[k], node);
      EXPECT_EQ(
          std::vector<uint32_t>(index.feature.begin() + index.offset[k], index.feature.begin() + index.offset[k + 1]),
          features);
      ++k;
    }
  }
}

TEST_F(WordsTest, RiseAndSumToOne) {
  for (size_t i = 0; i < 30; ++i) {
    const Words words = vocabulary_->transform(images_.image(i));
    double sum = 0;
    for (size_t k = 0; k < words.words.size(); ++k) {
      EXPECT_LT(words.words[k].word, vocabulary_->words());
      EXPECT_GT(words.words[k].weight, 0);
      EXPECT_TRUE(k == 0 || words.words[k - 1].word < words.words[k].word);
      sum += static_cast<double>(words.words[k].weight);
    }
    EXPECT_NEAR(sum, 1, 1e-5);
  }
}

TEST_F(WordsTest, DirectIndexHoldsEachFeatureOnce) {
  const auto image = images_.image(3);
  const DirectIndex index = vocabulary_->direct_index(image);
  EXPECT_TRUE(std::is_sorted(index.node.begin(), index.node.end()));
  EXPECT_EQ(std::set<uint32_t>(index.node.begin(), index.node.end()).size(), index.node.size());
  EXPECT_LE(index.node.size(), 25u);
  EXPECT_EQ(index.offset.front(), 0u);
  EXPECT_EQ(index.offset.back(), image.size());
  EXPECT_EQ(std::set<uint32_t>(index.feature.begin(), index.feature.end()).size(), image.size());
}

TEST_F(WordsTest, OfNothingAreNone) {
  EXPECT_TRUE(vocabulary_->transform({}).words.empty());
  const DirectIndex index = vocabulary_->direct_index({});
  EXPECT_TRUE(index.node.empty() && index.feature.empty());
  EXPECT_THAT(index.offset, testing::ElementsAre(0u));
}

TEST_F(WordsTest, AreTheSameByEveryInstructionSet) {
  for (size_t i = 0; i < 5; ++i) expect_scalar_twin([&] { return vocabulary_->transform(images_.image(i)); });
}

TEST_F(WordsTest, ScoreIsOneOfEqualNoneOfDisjointAndSymmetric) {
  std::vector<std::vector<WordWeight>> all;
  for (size_t i = 0; i < 30; ++i) all.push_back(vocabulary_->transform(images_.image(i)).words);
  for (const auto& a : all) {
    const WeightsByWord weights(a);
    EXPECT_NEAR(weights.score(a), 1, 1e-5);
    for (const auto& b : all) {
      EXPECT_EQ(weights.score(b), WeightsByWord(b).score(a));
      double difference = 0;  // as the paper writes it
      std::map<uint32_t, double> by_word;
      for (const WordWeight& w : a) by_word[w.word] += static_cast<double>(w.weight);
      for (const WordWeight& w : b) by_word[w.word] -= static_cast<double>(w.weight);
      for (const auto& [word, weight] : by_word) difference += std::abs(weight);
      EXPECT_NEAR(weights.score(b), 1 - difference / 2, 1e-5);
    }
  }
  EXPECT_EQ(WeightsByWord({{1, 0.5f}, {4, 0.5f}}).score({{2, 0.25f}, {3, 0.75f}}), 0);
  EXPECT_EQ(WeightsByWord({}).score({{2, 1.0f}}), 0);
  EXPECT_EQ(WeightsByWord({{2, 1.0f}}).score({}), 0);
}

}  // namespace
}  // namespace covis
