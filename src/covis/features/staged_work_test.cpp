// SPDX-License-Identifier: Apache-2.0
#include "covis/features/staged_work.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>
#include <set>

namespace covis {
namespace {

TEST(StagedWork, DoesEachTaskOnceAndStagesInOrder) {
  constexpr int kTasks = 7;
  std::vector<int> first(kTasks), second(kTasks), third(1);
  StagedWork work(
      {{kTasks, [&](int k) { ++first[static_cast<size_t>(k)]; }},
       {kTasks, [&](int k) { second[static_cast<size_t>(k)] += first[static_cast<size_t>(kTasks - 1 - k)]; }},
       {1, [&](int) {
          for (const int value : second) third[0] += value;
        }}});
  int sum = 0;
  for (int round = 1; round <= 200; ++round) {
    work.run();
    ASSERT_EQ(first, std::vector<int>(kTasks, round));
    sum += round;
    ASSERT_EQ(second, std::vector<int>(kTasks, sum));
  }
}

// Two tasks that wait for each other end only when two threads have them.
TEST(StagedWork, TwoThreadsTakeTasks) {
  std::mutex mutex;
  std::condition_variable met;
  int there = 0;
  std::set<std::thread::id> threads;
  StagedWork work({{2, [&](int) {
                      std::unique_lock lock(mutex);
                      threads.insert(std::this_thread::get_id());
                      ++there;
                      met.notify_all();
                      met.wait(lock, [&] { return there == 2; });
                    }}});
  work.run();
  EXPECT_EQ(threads.size(), 2u);
  EXPECT_TRUE(threads.contains(std::this_thread::get_id()));
}

}  // namespace
}  // namespace covis
