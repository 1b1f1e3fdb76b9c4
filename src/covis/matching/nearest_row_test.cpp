// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/nearest_row.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "covis/core/test_targets.h"
#include "covis/matching/test_matching.h"

namespace covis {
namespace {

// By the scalar twin and by every instruction set: what a plain search finds, ties and padding among it.
TEST(NearestRow, FindsTheTwoNearestAndTheNearestOfEachColumn) {
  Random random(77);
  for (const size_t count : {0u, 1u, 2u, 7u, 8u, 9u, 100u, 1003u}) {
    Features f = no_features();
    for (size_t j = 0; j < count; ++j) {
      // Few different ones, so that there are ties.
      add(f, 1, 1, 0, {{random.below(4), j % 3 ? 0 : ~uint64_t{0}, random.below(3), random.below(2)}});
    }
    std::vector<uint8_t> use(count);
    for (size_t j = 0; j < count; ++j) use[j] = count < 3 || random.below(5) != 0;
    const DescriptorPlanes planes(f, use);
    std::vector<Descriptor> queries;
    for (int i = 0; i < 20; ++i) queries.push_back({{random.below(4), random.below(2), random.below(3), 0}});
    std::vector<uint64_t> expected_column(planes.size(), kFarthest);
    std::vector<NearestTwo> expected;
    for (uint32_t i = 0; i < queries.size(); ++i) {
      std::vector<uint64_t> keys;
      for (uint32_t j = 0; j < planes.size(); ++j) {
        const int distance = hamming(queries[i], f.descriptor[static_cast<size_t>(planes.feature(j))]);
        keys.push_back(near_key(distance, j));
        expected_column[j] = std::min(expected_column[j], near_key(distance, i));
      }
      std::sort(keys.begin(), keys.end());
      keys.resize(std::max<size_t>(keys.size(), 2), kFarthest);
      expected.push_back({keys[0], keys[1]});
    }
    for_each_target([&] {
      AlignedVector<uint64_t> column(planes.padded_size(), kFarthest);
      for (uint32_t i = 0; i < queries.size(); ++i) {
        const NearestTwo two = nearest_row(queries[i], i, planes, column.data());
        EXPECT_EQ(two.best, expected[i].best);
        EXPECT_EQ(two.second, expected[i].second);
      }
      EXPECT_TRUE(std::equal(expected_column.begin(), expected_column.end(), column.begin()));
    });
  }
}

}  // namespace
}  // namespace covis
