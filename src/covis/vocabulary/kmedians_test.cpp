// SPDX-License-Identifier: Apache-2.0
#include "covis/vocabulary/kmedians.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <numeric>
#include <set>

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

}  // namespace
}  // namespace covis
