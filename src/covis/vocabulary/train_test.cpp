// SPDX-License-Identifier: Apache-2.0
#include "covis/vocabulary/train.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "covis/vocabulary/test_vocabulary.h"

namespace covis {
namespace {

TEST(Train, IsTheSameForAnyNumberOfThreads) {
  const MadeImages images(11, 700, 100, 300);  // 70,000: the upper node is worked on by all threads together
  const TemporaryFolder folder;
  std::vector<std::string> bytes;
  for (const int threads : {1, 2, 3}) {
    TrainOptions options;
    options.branching = 8;
    options.depth = 3;
    options.threads = threads;
    options.iterations = 6;
    const auto vocabulary = train_vocabulary(images.descriptors, images.offsets, options);
    ASSERT_TRUE(vocabulary) << vocabulary.error().message;
    ASSERT_TRUE((*vocabulary)->save(folder / "voc"));
    bytes.push_back(read_file(folder / "voc"));
  }
  EXPECT_EQ(bytes[0], bytes[1]);
  EXPECT_EQ(bytes[0], bytes[2]);
}

TEST(Train, SeedChangesTheResult) {
  const MadeImages images(12, 20, 50, 30);
  TrainOptions options;
  options.depth = 2;
  const auto a = train_vocabulary(images.descriptors, images.offsets, options);
  options.seed = 1;
  const auto b = train_vocabulary(images.descriptors, images.offsets, options);
  ASSERT_TRUE(a && b);
  EXPECT_NE((*a)->checksum(), (*b)->checksum());
}

TEST(Train, WeightsAreLogarithmsOfImagesOverImagesWithTheWord) {
  const MadeImages images(13, 25, 60, 40);
  const auto vocabulary = train_made(images, 6, 3);
  std::vector<std::set<size_t>> images_of(vocabulary->words());
  for (size_t i = 0; i < 25; ++i) {
    for (const Descriptor& descriptor : images.image(i)) images_of[vocabulary->word(descriptor)].insert(i);
  }
  for (uint32_t word = 0; word < vocabulary->words(); ++word) {
    ASSERT_FALSE(images_of[word].empty());
    EXPECT_FLOAT_EQ(vocabulary->weight(word),
                    static_cast<float>(std::log(25.0 / static_cast<double>(images_of[word].size()))));
  }
}

TEST(Train, SplitsNoNodeOfEqualMembers) {
  Random random(14);
  std::vector<Descriptor> descriptors;
  for (int i = 0; i < 4; ++i) descriptors.insert(descriptors.end(), 10, random_descriptor(random));
  TrainOptions options;
  options.branching = 4;
  options.depth = 6;
  const auto vocabulary = train_vocabulary(descriptors, std::vector<uint64_t>{0, 20, 40}, options);
  ASSERT_TRUE(vocabulary);
  EXPECT_EQ((*vocabulary)->words(), 4u);
  EXPECT_EQ((*vocabulary)->nodes(), 5u);
}

TEST(Train, TellsProgressAndStops) {
  const MadeImages images(15, 20, 50, 30);
  TrainOptions options;
  options.threads = 2;
  double last = 0;
  bool rises = true;
  const auto vocabulary = train_vocabulary(images.descriptors, images.offsets, options, [&](double done) {
    rises &= done >= last;
    last = done;
    return true;
  });
  EXPECT_TRUE(vocabulary);
  EXPECT_TRUE(rises);
  EXPECT_GT(last, 0.15);
  const auto stopped = train_vocabulary(images.descriptors, images.offsets, options, [](double) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_THAT(stopped.error().message, testing::HasSubstr("stopped"));
}

TEST(Train, TellsWhatIsWrong) {
  const MadeImages images(16, 2, 50, 30);
  const auto message = [&](const TrainOptions& options, std::vector<uint64_t> offsets) {
    const auto trained = train_vocabulary(images.descriptors, offsets, options);
    return trained ? "trained" : trained.error().message;
  };
  EXPECT_EQ(message({}, {0, 50, 100}), "trained");
  EXPECT_THAT(message({.branching = 1}, {0, 50, 100}), testing::HasSubstr("train.branching"));
  EXPECT_THAT(message({.depth = 0}, {0, 50, 100}), testing::HasSubstr("train.depth"));
  EXPECT_THAT(message({}, {0, 50}), testing::HasSubstr("offsets"));
  EXPECT_THAT(message({}, {}), testing::HasSubstr("offsets"));
  EXPECT_THAT(message({}, {0, 70, 60, 100}), testing::HasSubstr("offsets"));
  const auto equal = train_vocabulary(std::vector<Descriptor>(9), std::vector<uint64_t>{0, 9}, {});
  ASSERT_FALSE(equal);
  EXPECT_THAT(equal.error().message, testing::HasSubstr("the same"));
}

TEST(TrainingSet, KeepsAllThatFits) {
  const MadeImages images(17, 30, 200, 50);
  TrainingSet set(8, 0);
  for (size_t i = 0; i < 30; ++i) set.add_image(images.image(i));
  EXPECT_TRUE(std::equal(images.descriptors.begin(), images.descriptors.end(), set.descriptors().begin(),
                         set.descriptors().end()));
  EXPECT_TRUE(std::equal(images.offsets.begin(), images.offsets.end(), set.offsets().begin(), set.offsets().end()));
  EXPECT_EQ(set.seen(), images.descriptors.size());
}

TEST(TrainingSet, SamplesEvenlyWhatDoesNotFit) {
  const MadeImages images(18, 100, 1000, 50);  // 4.3 MB
  TrainingSet one(1, 0), two(1, 0);
  for (size_t i = 0; i < 100; ++i) one.add_image(images.image(i));
  for (size_t i = 0; i < 100; ++i) two.add_image(images.image(i));
  EXPECT_EQ(one.seen(), 100000u);
  EXPECT_LE(one.descriptors().size(), (1u << 20) / 43);
  EXPECT_TRUE(std::equal(one.descriptors().begin(), one.descriptors().end(), two.descriptors().begin(),
                         two.descriptors().end()));
  ASSERT_EQ(one.images(), 100u);
  for (size_t i = 0; i < 100; ++i) {  // an eighth of each, four standard deviations
    EXPECT_NEAR(static_cast<double>(one.offsets()[i + 1] - one.offsets()[i]), 125, 42);
  }
}

}  // namespace
}  // namespace covis
