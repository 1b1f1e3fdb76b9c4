// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "covis/vocabulary/test_vocabulary.h"

namespace covis {
namespace {

// A word that every image has says nothing; a shallow word is its own node of the direct index.
TEST(VocabularyBuild, WeightlessAndShallowWords) {
  Descriptor ones;
  ones.bits.fill(~uint64_t{0});
  const auto vocabulary = Vocabulary::build(2, 4, {{{}, 0, 0.0f}, {ones, 0, 2.0f}});
  ASSERT_TRUE(vocabulary);
  const std::vector<Descriptor> features = {{}, ones, {}};
  const Words words = (*vocabulary)->transform(features);
  EXPECT_THAT(words.words, testing::ElementsAre(WordWeight{1, 1.0f}));
  const DirectIndex index = (*vocabulary)->direct_index(features);
  EXPECT_THAT(index.node, testing::ElementsAre(1u, 2u));
  EXPECT_THAT(index.feature, testing::ElementsAre(0u, 2u, 1u));
  EXPECT_TRUE((*vocabulary)->transform(std::vector<Descriptor>(3)).words.empty());
}

TEST(VocabularyBuild, TellsWhatIsWrong) {
  const auto message = [](int branching, int depth, const std::vector<VocabularyNode>& nodes) {
    const auto built = Vocabulary::build(branching, depth, nodes);
    return built ? "built" : built.error().message;
  };
  EXPECT_THAT(message(1, 4, {{}}), testing::HasSubstr("branching"));
  EXPECT_THAT(message(300, 4, {{}}), testing::HasSubstr("branching"));
  EXPECT_THAT(message(2, 0, {{}}), testing::HasSubstr("depth"));
  EXPECT_THAT(message(2, 4, {}), testing::HasSubstr("no nodes"));
  EXPECT_THAT(message(2, 4, {{{}, 1, 0}}), testing::HasSubstr("node 1: its parent"));
  EXPECT_THAT(message(2, 1, {{{}, 0, 0}, {{}, 1, 0}}), testing::HasSubstr("node 2: it lies deeper"));
  EXPECT_THAT(message(2, 1, {{{}, 0, 0}, {{}, 0, 0}, {{}, 0, 0}}), testing::HasSubstr("more than 2 children"));
  EXPECT_THAT(message(2, 1, {{{}, 0, -1}}), testing::HasSubstr("weight"));
  EXPECT_THAT(message(2, 1, {{{}, 0, NAN}}), testing::HasSubstr("weight"));
  EXPECT_THAT(message(2, 1, {{{}, 0, 1e30f}}), testing::HasSubstr("nor greater than a million"));
}

}  // namespace
}  // namespace covis
