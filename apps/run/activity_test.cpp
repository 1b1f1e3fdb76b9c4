// SPDX-License-Identifier: Apache-2.0
#include "apps/run/activity.h"

#include <gmock/gmock.h>

#include <csignal>
#include <new>
#include <stdexcept>
#include <system_error>
#include <thread>

namespace covis::app {
namespace {

// Throws where nothing can catch it, in a thread.
template <class Exception>
void end_by(const Exception& exception) {
  const char* words[] = {"covis", "run", "desk", "--quiet"};
  set_activity(4, words);
  enter_frame(7);
  end_in_order_on_terminate();
  std::thread([&] { throw exception; }).join();
}

TEST(ActivityDeathTest, ALackOfMemoryOrThreadsEndsTheProcessInOrder) {
  EXPECT_EXIT(end_by(std::bad_alloc()), testing::ExitedWithCode(1), "^error: covis run desk, frame 7: the memory has");
  EXPECT_EXIT(end_by(std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again))),
              testing::ExitedWithCode(1), "frame 7: no thread could be started");
}

TEST(ActivityDeathTest, AnErrorOfTheProgramAborts) {
  EXPECT_EXIT(end_by(std::logic_error("a \x1b[2J b\n")), testing::KilledBySignal(SIGABRT),
              "^error: covis run desk, frame 7: a \\?\\[2J b\\?\n");
  EXPECT_EXIT(end_by(1), testing::KilledBySignal(SIGABRT), "frame 7: an exception of unknown kind");
}

}  // namespace
}  // namespace covis::app
