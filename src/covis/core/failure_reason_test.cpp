// SPDX-License-Identifier: Apache-2.0
#include "covis/core/failure_reason.h"

#include <gmock/gmock.h>

#include <new>
#include <stdexcept>
#include <system_error>

namespace covis {
namespace {

using testing::HasSubstr;

TEST(FailureReason, SaysWhichResourceHasRunOut) {
  const auto system = [](std::errc code) { return std::system_error(std::make_error_code(code)); };
  EXPECT_THAT(reason_of(std::bad_alloc()), HasSubstr("the memory has run out"));
  EXPECT_THAT(reason_of(system(std::errc::not_enough_memory)), HasSubstr("the memory has run out"));
  EXPECT_THAT(reason_of(std::runtime_error("OpenCV(4.6.0) alloc.cpp:73: error: (-4:Insufficient memory) Failed")),
              testing::StartsWith("the memory has run out"));
  EXPECT_THAT(reason_of(system(std::errc::resource_unavailable_try_again)),
              testing::AllOf(HasSubstr("no thread could be started"), HasSubstr("ulimit -u")));
  EXPECT_EQ(reason_of(std::runtime_error("something else")), "something else");
}

}  // namespace
}  // namespace covis
