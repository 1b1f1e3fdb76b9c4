// SPDX-License-Identifier: Apache-2.0
#include "covis/core/spilled_array.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <string>

namespace covis {
namespace {

struct Row {
  size_t number = 0;
  std::string text;
  char more[160] = {};
};
using Rows = SpilledArray<Row>;

Row row_of(size_t k) { return {k, std::string(k % 12, 'x'), {}}; }

void fill(Rows& rows, size_t count) {
  for (size_t k = rows.size(); k < count; ++k) rows.push_back(row_of(k));
}

void expect_whole(const Rows& rows) {
  for (size_t k = 0; k < rows.size(); ++k) ASSERT_TRUE(rows[k].number == k && rows[k].text.size() == k % 12) << k;
}

double resident_mb() {
  size_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return static_cast<double>(resident) * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

TEST(SpilledArray, HoldsWhatWasPutIntoIt) {
  Rows rows;
  EXPECT_TRUE(rows.empty());
  fill(rows, 5 * Rows::kPerBlock + 3);
  expect_whole(rows);
  rows.page_out();
  expect_whole(rows);
  rows[7].text = "changed";
  rows.page_out();
  EXPECT_EQ(rows[7].text, "changed") << "changes of older elements stay";
  EXPECT_EQ(rows.back().number, rows.size() - 1);
  const Rows& same = rows;
  const auto all = same.all();
  EXPECT_EQ(all.size(), rows.size());
  EXPECT_EQ((*std::ranges::lower_bound(all, size_t{9000}, {}, &Row::number)).number, 9000u);
}

TEST(SpilledArray, OlderElementsTakeNoResidentMemory) {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "a sanitizer's own memory stays";
#endif
  Rows rows;
  fill(rows, 4 * Rows::kPerBlock);
  const double before = resident_mb();
  fill(rows, 200 * Rows::kPerBlock);  // some 150 MB
  if (!SpillFile().map(4096).in_file) GTEST_SKIP() << "no file can be made here";
  EXPECT_LT(resident_mb(), before + 20);
  expect_whole(rows);
  rows.page_out();
  EXPECT_LT(resident_mb(), before + 20);
}

TEST(SpilledArray, StaysInMemoryWhereTheDiskIsFull) {
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit little{1 << 20, before.rlim_max};
  auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
  ::setrlimit(RLIMIT_FSIZE, &little);
  Rows rows;
  fill(rows, 4 * Rows::kPerBlock);
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  rows.page_out();
  expect_whole(rows);
}

TEST(SpilledArray, TheFrontCanGo) {
  Rows rows;
  fill(rows, 2 * Rows::kPerBlock + 10);
  rows.erase_front(Rows::kPerBlock + 3);
  ASSERT_EQ(rows.size(), Rows::kPerBlock + 7);
  for (size_t k = 0; k < rows.size(); ++k) ASSERT_EQ(rows[k].number, k + Rows::kPerBlock + 3);
  rows.push_back(row_of(1));
  EXPECT_EQ(rows.back().number, 1u);
}

TEST(SpilledArray, MovesWithItsElements) {
  Rows rows;
  fill(rows, 2 * Rows::kPerBlock);
  Rows other = std::move(rows);
  fill(other, 3 * Rows::kPerBlock);
  expect_whole(other);
}

}  // namespace
}  // namespace covis
