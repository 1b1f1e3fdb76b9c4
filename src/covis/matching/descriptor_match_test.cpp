// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/descriptor_match.h"

#include <gtest/gtest.h>

#include "covis/matching/test_matching.h"

namespace covis {
namespace {

TEST(DescriptorMatch, FindsAPermutationAndSkipsWhatIsAmbiguousOrUnused) {
  Random random(6);
  Features a = no_features(), b = no_features();
  constexpr int kCount = 200;
  for (int i = 0; i < kCount; ++i) add(a, 10, 10, 0, random_descriptor(random));
  for (int i = 0; i < kCount; ++i) {
    add(b, 10, 10, 0, turned(a.descriptor[static_cast<size_t>((i * 7) % kCount)], 15, random));
  }
  b.descriptor[20] = b.descriptor[21];  // two of a kind: neither the lost original nor the doubled one may match
  std::vector<uint8_t> use_b(kCount, 1);
  use_b[50] = 0;
  const auto matches = match_descriptors(a, {}, b, use_b, {});
  EXPECT_EQ(matches.size(), static_cast<size_t>(kCount - 3));
  for (const FeatureMatch& m : matches) EXPECT_EQ(m.a, (m.b * 7) % kCount);
}

}  // namespace
}  // namespace covis
