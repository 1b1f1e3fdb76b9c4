// SPDX-License-Identifier: Apache-2.0
#include "covis/io/npy.h"

#include <gmock/gmock.h>

#include "covis/io/test_npy.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string npy_error(const std::string& bytes) {
  ImageF array;
  const auto parsed = parse_npy("d.npy", bytes, array);
  return parsed ? "" : parsed.error().message;
}

TEST(Npy, IsReadInBothVersions) {
  const std::vector<float> values{1, 2, 3, 4, 5, 6.5F};
  for (const int version : {1, 2}) {
    ImageF array;
    const auto parsed = parse_npy("d.npy", npy_bytes(values, "(2, 3)", "'<f4'", "False", version), array);
    ASSERT_TRUE(parsed) << parsed.error().message;
    EXPECT_EQ(array.width(), 3);
    EXPECT_EQ(array.height(), 2);
    EXPECT_EQ(array(0, 1), 4);
    EXPECT_EQ(array(2, 1), 6.5F);
  }
}

TEST(Npy, NamesTheFieldThatIsWrong) {
  const std::vector<float> values(6);
  EXPECT_THAT(npy_error(npy_bytes(values, "(2, 3)", "'<f8'")),
              AllOf(HasSubstr("d.npy: descr is '<f8'"), HasSubstr("'<f4'")));
  EXPECT_THAT(npy_error(npy_bytes(values, "(2, 3)", "[('a', '<f4'), ('b', '<f4')]")), HasSubstr("descr is [('a'"));
  EXPECT_THAT(npy_error(npy_bytes(values, "(2, 3)", "'<f4'", "True")), HasSubstr("fortran_order is True"));
  for (const char* shape :
       {"(6,)", "(1, 2, 3)", "()", "(-2, 3)", "(0, 3)", "(2, x)", "(99999, 1)", "6", "(18446744073709551617, 3)"}) {
    EXPECT_THAT(npy_error(npy_bytes(values, shape)), HasSubstr(std::string("shape is ") + shape));
  }
  EXPECT_THAT(npy_error(npy_bytes(values, "(32767, 32767)")), HasSubstr("cut short"));
  EXPECT_THAT(npy_error(npy_bytes(values, "(1, 3)")), AllOf(HasSubstr("12 bytes"), HasSubstr("24")));
}

TEST(Npy, ThatIsCutShortIsAnErrorAtEveryByte) {
  for (const int version : {1, 2}) {
    const std::string whole = npy_bytes({1, 2, 3, 4, 5, 6}, "(2, 3)", "'<f4'", "False", version);
    for (size_t size = 0; size < whole.size(); ++size) EXPECT_NE(npy_error(whole.substr(0, size)), "") << size;
  }
  EXPECT_THAT(npy_error("hello, this is text"), HasSubstr("not a NumPy file"));
  EXPECT_THAT(npy_error(npy_bytes({1}, "(1, 1)", "'<f4'", "False", 3)), HasSubstr("version 1.0 or 2.0"));
}

}  // namespace
}  // namespace covis::io
