// SPDX-License-Identifier: Apache-2.0
#include "covis/core/aligned.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace covis {
namespace {

TEST(Aligned, DataStartsAtACacheLineHoweverItGrows) {
  AlignedVector<uint8_t> bytes;
  for (int i = 0; i < 5000; ++i) {
    bytes.push_back(static_cast<uint8_t>(i));
    ASSERT_EQ(reinterpret_cast<uintptr_t>(bytes.data()) % 64, 0u) << i;
  }
  for (size_t i = 0; i < bytes.size(); ++i) ASSERT_EQ(bytes[i], static_cast<uint8_t>(i));
  const AlignedVector<double> numbers(3, 1.5);
  EXPECT_EQ(reinterpret_cast<uintptr_t>(numbers.data()) % 64, 0u);
}

}  // namespace
}  // namespace covis
