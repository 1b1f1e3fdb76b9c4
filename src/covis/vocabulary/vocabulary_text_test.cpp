// SPDX-License-Identifier: Apache-2.0
#include "covis/vocabulary/vocabulary_text.h"

#include <gmock/gmock.h>

#include <cstring>

#include "covis/vocabulary/test_vocabulary.h"

namespace covis {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST_F(VocabularyFile, TextHoldsTheSame) {
  ASSERT_TRUE(vocabulary_->save_text(folder_ / "tree.txt"));
  const auto loaded = Vocabulary::load(folder_ / "tree.txt");
  ASSERT_TRUE(loaded) << loaded.error().message;
  ASSERT_TRUE((*loaded)->save(folder_ / "again"));
  EXPECT_EQ(read_file(folder_ / "again"), bytes_);
}

std::string text_of_bytes(int first) {  // 32 of them
  std::string text;
  for (int i = 0; i < 32; ++i) text += std::to_string(first + i) + " ";
  return text;
}

TEST_F(VocabularyFile, ReadsTextAsOthersWriteIt) {
  // Depth first, blanks at the ends of lines, carriage returns, exponents.
  write_file(folder_ / "tree.txt", "10 6  0 0 \r\n0 0 " + text_of_bytes(0) + " 0 \r\n1 1 " + text_of_bytes(1) +
                                       "5.25e-1 \n1 1 " + text_of_bytes(100) + "2 \n0 1 " + text_of_bytes(200) +
                                       "3\n\n \n");
  const auto loaded = Vocabulary::load(folder_ / "tree.txt");
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ((*loaded)->branching(), 10);
  EXPECT_EQ((*loaded)->depth(), 6);
  EXPECT_EQ((*loaded)->words(), 3u);
  EXPECT_EQ((*loaded)->nodes(), 5u);
  Descriptor descriptor;  // bytes 200, 201 …
  for (size_t i = 0; i < 32; ++i) descriptor.bits[i / 8] |= uint64_t{200 + i} << (8 * (i % 8));
  EXPECT_EQ((*loaded)->weight((*loaded)->word(descriptor)), 3.0f);
}

TEST_F(VocabularyFile, TextErrorsNameTheLine) {
  const std::string word = text_of_bytes(0) + "1\n";
  EXPECT_THAT(load("10 6 1 0\n0 1 " + word), AllOf(HasSubstr("bad: line 1"), HasSubstr("scoring 1")));
  EXPECT_THAT(load("10 6 0 0\n0 1 " + word + "0 1 1 2 3\n"), HasSubstr("line 3"));
  EXPECT_THAT(load("10 6 0 0\n0 1 " + text_of_bytes(240) + "1\n"), HasSubstr("line 2"));  // 256 is no byte
  EXPECT_THAT(load("10 6 0 0\n0 2 " + word), HasSubstr("line 2"));
  EXPECT_THAT(load("10 6 0 0\n2 1 " + word), AllOf(HasSubstr("line 2"), HasSubstr("parent 2")));
  EXPECT_THAT(load("10 6 0 0\n0 1 " + word + "1 1 " + word), AllOf(HasSubstr("line 3"), HasSubstr("is a word")));
  EXPECT_THAT(load("10 6 0 0\n0 1 " + text_of_bytes(0) + "nan\n"), HasSubstr("weight"));
  EXPECT_THAT(load("10 6 0 0\n"), HasSubstr("no nodes"));
  EXPECT_THAT(load("1 6 0 0\n0 1 " + word), HasSubstr("branching"));
  EXPECT_THAT(load("10 6 0 0 0\n0 1 " + word), HasSubstr("no vocabulary"));
  EXPECT_THAT(load("-10 99999999999999999999 0 0\n"), HasSubstr("no vocabulary"));
}

}  // namespace
}  // namespace covis
