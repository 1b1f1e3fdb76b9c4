// SPDX-License-Identifier: Apache-2.0
#include "covis/core/log.h"

#include <gmock/gmock.h>

#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace covis {
namespace {

TEST(Log, ReachesTheSinkOneMessageAtATimeAndWithoutOneIsDropped) {
  log(LogLevel::error, "nobody listens");
  std::vector<std::pair<LogLevel, std::string>> heard;  // without a lock: log() has one
  set_log_sink([&](LogLevel level, std::string_view message) { heard.emplace_back(level, message); });
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 2; ++t) {
      threads.emplace_back([] {
        for (int i = 0; i < 500; ++i) log(LogLevel::warning, "hello");
      });
    }
  }
  set_log_sink({});
  log(LogLevel::error, "nobody listens any more");
  EXPECT_EQ(heard.size(), 1000u);
  EXPECT_THAT(heard, testing::Each(testing::Pair(LogLevel::warning, "hello")));
}

TEST(Log, WhatTheSinkThrowsIsDropped) {
  int called = 0;
  set_log_sink([&](LogLevel, std::string_view) {
    ++called;
    throw std::runtime_error("the sink's own");
  });
  EXPECT_NO_THROW(log(LogLevel::info, "hello"));
  EXPECT_NO_THROW(log(LogLevel::info, "hello again"));
  set_log_sink({});
  EXPECT_EQ(called, 2);
}

TEST(Log, DropsMessagesDuringAPause) {
  std::vector<std::string> heard;
  set_log_sink([&](LogLevel, std::string_view message) { heard.emplace_back(message); });
  log(LogLevel::info, "before");
  {
    const LogPause outer, inner;
    log(LogLevel::error, "during");
  }
  log(LogLevel::info, "after");
  set_log_sink({});
  EXPECT_THAT(heard, testing::ElementsAre("before", "after"));
}

}  // namespace
}  // namespace covis
