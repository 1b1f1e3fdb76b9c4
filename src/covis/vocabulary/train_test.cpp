// SPDX-License-Identifier: Apache-2.0
#include "covis/vocabulary/train.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "covis/vocabulary/kmedians.h"
#include "covis/vocabulary/test_vocabulary.h"

namespace covis {
namespace {

const ForRanges kAlone = [](size_t n, const auto& work) { work(0, n); };
const ForRanges kBackwards = [](size_t n, const auto& work) {
  for (size_t end = n; end > 0; end -= std::min<size_t>(end, 7)) work(end - std::min<size_t>(end, 7), end);
};

std::vector<uint32_t> all_of(const MadeImages& images) {
  std::vector<uint32_t> members(images.descriptors.size());
  std::iota(members.begin(), members.end(), 0u);
  return members;
}

TEST(KMedians, EndsWithMediansOfNearestMembers) {
  const MadeImages images(3, 10, 100, 6);
  const std::vector<uint32_t> members = all_of(images);
  Random random(1);
  const Clusters clusters = k_medians(images.descriptors, members, 6, 1000, random, kAlone);
  ASSERT_LE(clusters.centres.size(), 6u);
  ASSERT_GE(clusters.centres.size(), 2u);
  for (size_t i = 0; i < members.size(); ++i) {
    const int own = hamming(images.descriptors[i], clusters.centres[clusters.of[i]]);
    for (size_t c = 0; c < clusters.centres.size(); ++c) {
      const int other = hamming(images.descriptors[i], clusters.centres[c]);
      EXPECT_TRUE(c < clusters.of[i] ? own < other : own <= other);
    }
  }
  for (size_t c = 0; c < clusters.centres.size(); ++c) {
    const auto count = std::count(clusters.of.begin(), clusters.of.end(), static_cast<uint8_t>(c));
    ASSERT_GT(count, 0);
    for (size_t bit = 0; bit < 256; ++bit) {
      const auto set_in = [&](const Descriptor& d) { return ((d.bits[bit / 64] >> (bit % 64)) & 1) != 0; };
      int64_t ones = 0;
      for (size_t i = 0; i < members.size(); ++i) ones += clusters.of[i] == c && set_in(images.descriptors[i]) ? 1 : 0;
      if (2 * ones == count) continue;
      EXPECT_EQ(set_in(clusters.centres[c]), 2 * ones > count);
    }
  }
}

TEST(KMedians, FindsCentresThatAreFarApart) {
  Random random(5);
  std::vector<Descriptor> centres, descriptors;
  for (int c = 0; c < 4; ++c) centres.push_back(random_descriptor(random));
  for (int i = 0; i < 4000; ++i) descriptors.push_back(near(centres[static_cast<size_t>(i % 4)], 3, random));
  std::vector<uint32_t> members(descriptors.size());
  std::iota(members.begin(), members.end(), 0u);
  const Clusters clusters = k_medians(descriptors, members, 4, 100, random, kAlone);
  const auto less = [](const Descriptor& a, const Descriptor& b) { return a.bits < b.bits; };
  std::vector<Descriptor> found(clusters.centres.begin(), clusters.centres.end());
  std::sort(found.begin(), found.end(), less);
  std::sort(centres.begin(), centres.end(), less);
  EXPECT_EQ(found, centres);
}

TEST(KMedians, IsTheSameHoweverTheWorkIsShared) {
  const MadeImages images(4, 10, 100, 20);
  Random one(2), two(2);
  const Clusters a = k_medians(images.descriptors, all_of(images), 9, 20, one, kAlone);
  const Clusters b = k_medians(images.descriptors, all_of(images), 9, 20, two, kBackwards);
  EXPECT_EQ(a.of, b.of);
  EXPECT_TRUE(a.centres == b.centres);
}

TEST(KMedians, GivesFewerClustersThanAskedForOfFewDistinctMembers) {
  Random random(6);
  const Descriptor a = random_descriptor(random), b = random_descriptor(random);
  const std::vector<Descriptor> descriptors = {a, b, a, a, b};
  const Clusters clusters = k_medians(descriptors, std::vector<uint32_t>{0, 1, 2, 3, 4}, 10, 20, random, kAlone);
  ASSERT_EQ(clusters.centres.size(), 2u);
  for (size_t i = 0; i < 5; ++i) EXPECT_EQ(clusters.centres[clusters.of[i]], descriptors[i]);
}

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
