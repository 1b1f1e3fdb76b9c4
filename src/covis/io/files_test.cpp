// SPDX-License-Identifier: Apache-2.0
// Files read whole, and stamps.
#include "covis/io/files.h"

#include "covis/core/random.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Files : public RecordingTest {};

TEST_F(Files, ReadWhole) {
  const std::string bytes("one\0two\n", 8);
  write("some", bytes);
  EXPECT_EQ(*read_text(folder / "some"), bytes);
  std::string memory(100, 'x');
  ASSERT_TRUE(read_bytes(folder / "some", memory));
  EXPECT_EQ(memory, bytes);
  EXPECT_THAT(*read_text("/proc/self/status"), HasSubstr("Pid:")) << "a file whose size is not known before";
  EXPECT_THAT(read_text(folder).error().message, HasSubstr("it is a folder"));
  EXPECT_THAT(read_text(folder / "none").error().message, HasSubstr("none: it can't be opened"));
}

TEST_F(Files, TextIsInUtf8) {
  write("marked", "\xef\xbb\xbfone\n");
  EXPECT_EQ(*read_text(folder / "marked"), "one\n");
  write("short", "\xef\xbb");
  EXPECT_EQ(*read_text(folder / "short"), "\xef\xbb");
  write("empty", "");
  EXPECT_EQ(*read_text(folder / "empty"), "");
  for (const std::string& wide : {std::string("\xff\xfeo\0n\0", 6), std::string("\xfe\xff\0o", 4),
                                  std::string("o\0n\0", 4), std::string("\0o\0n", 4)}) {
    write("wide", wide);
    EXPECT_THAT(read_text(folder / "wide").error().message,
                AllOf(HasSubstr("wide: it is in UTF-16"), HasSubstr("UTF-8")));
  }
}

TEST_F(Files, ReadTheirHeads) {
  write("some", "abcdef");
  EXPECT_EQ(*read_head(folder / "some", 4), "abcd");
  EXPECT_EQ(*read_head(folder / "some", 40), "abcdef");
  EXPECT_THAT(read_head("/dev/zero", 4).error().message, HasSubstr("it is a pipe or a device"));
}

TEST(Stamps, AreExact) {
  EXPECT_EQ(parse_stamp("1305031102.175304"), 1305031102175304000);
  EXPECT_EQ(parse_stamp("1403715273262142976"), 1403715273262142976);
  EXPECT_EQ(parse_stamp("12"), 12'000'000'000);
  EXPECT_EQ(parse_stamp("1.5e0"), 1'500'000'000);
  EXPECT_EQ(parse_stamp("-0.25"), -250'000'000);
  EXPECT_FALSE(parse_stamp("x"));
  EXPECT_FALSE(parse_stamp("nan"));
  EXPECT_EQ(stamp_text(1305031102175304000), "1305031102.175304000");
  EXPECT_EQ(stamp_text(-250'000'000), "-0.250000000");
}

TEST(Stamps, AreReadHoweverTheyAreWritten) {
  EXPECT_EQ(parse_stamp("1.036000e-01"), 103'600'000);
  EXPECT_EQ(parse_stamp("1.403715273262142976e+18"), 1403715273262142976) << "nanoseconds with an exponent";
  EXPECT_EQ(parse_stamp("1403715273262142976.000000"), 1403715273262142976) << "nanoseconds with decimals";
  EXPECT_EQ(parse_stamp("1403715273.262142976"), 1403715273262142976);
  EXPECT_EQ(parse_stamp("0.29999999999999999"), 300'000'000) << "rounded, not cut";
  EXPECT_EQ(parse_stamp("0.9999999996"), 1'000'000'000);
  EXPECT_EQ(parse_stamp("-0.9999999996"), -1'000'000'000);
  EXPECT_EQ(parse_stamp("1e-10"), 0);
  EXPECT_EQ(parse_stamp("6e-10"), 1);
  EXPECT_EQ(parse_stamp("1e-300"), 0);
  EXPECT_EQ(parse_stamp("000000.5"), 500'000'000);
  EXPECT_EQ(parse_stamp("0"), 0);
  EXPECT_EQ(parse_stamp("+.5"), 500'000'000);
  EXPECT_EQ(parse_stamp("1400076021614"), 1400076021614'000'000) << "milliseconds";
  EXPECT_EQ(parse_stamp("1400076021614572"), 1400076021614572'000) << "microseconds";
  EXPECT_EQ(parse_stamp("1400076021614572.25"), 1400076021614572'250);
  EXPECT_EQ(parse_stamp("14000760216145720"), 14000760216145720) << "nanoseconds";
  EXPECT_EQ(parse_stamp("1400076021614572", WholeStamp::nanoseconds), 1400076021614572);
  EXPECT_EQ(parse_stamp("12", WholeStamp::nanoseconds), 12);
  EXPECT_EQ(parse_stamp("12.0", WholeStamp::nanoseconds), 12'000'000'000);
  for (const char* text : {"", "-", "+", ".", "e5", "1e", "1.2.3", "0x10", "12s", "inf", "1e300",
                           "99999999999999999999", "100000000000", "9223372036854775807", "-5000000000000000000"}) {
    EXPECT_FALSE(parse_stamp(text)) << text;
  }
}

TEST_F(Files, ListStampsInTheFirstColumnOrBehindNumbersOfFrames) {
  const auto stamps = [&](const std::string& text) {
    write("times.txt", text);
    return *read_stamps(folder / "times.txt");
  };
  using testing::ElementsAre;
  EXPECT_THAT(stamps("00000 1441204213.936500 1.5\n00001 1441204213.986500 1.5\n"),
              ElementsAre(1441204213936500000, 1441204213986500000));
  EXPECT_THAT(stamps("1 0.5\n2 0.7\n3 0.9\n"), ElementsAre(500'000'000, 700'000'000, 900'000'000));
  EXPECT_THAT(stamps("0 0.7\n1 0.5\n"), ElementsAre(0, 1'000'000'000)) << "what is behind does not rise";
  EXPECT_THAT(stamps("0 a.png\n1 b.png\n"), ElementsAre(0, 1'000'000'000));
  EXPECT_THAT(stamps("1400076021614\n1400126021614\n"), ElementsAre(1400076021614, 1400126021614))
      << "20 Hz as nanoseconds since a device was started, and 14 hours apart as milliseconds";
  EXPECT_THAT(stamps("0 0.5\n2 0.7\n"), ElementsAre(0, 2'000'000'000)) << "the first are not the rows' numbers";
}

// Whatever has 11, 12, 14 or 15 digits, or 10 of more than 146 years, can't be seconds.
TEST_F(Files, ListStampsInNanosecondsOfAnyNumberOfDigits) {
  using testing::ElementsAre;
  const auto stamps = [&](const std::string& text) {
    write("times.txt", text);
    const auto read = read_stamps(folder / "times.txt");
    EXPECT_TRUE(read) << read.error().message;
    return read ? *read : std::vector<Timestamp>{};
  };
  EXPECT_THAT(stamps("140007602161411\n140007652161411\n"), ElementsAre(140007602161411, 140007652161411));
  EXPECT_THAT(stamps("14000760216\n14050760216\n"), ElementsAre(14000760216, 14050760216));
  EXPECT_THAT(stamps("4590000000\n4640000000\n"), ElementsAre(4590000000, 4640000000)) << "one could be seconds";
  EXPECT_THAT(stamps("0\n999950000000\n999999999999\n"), ElementsAre(0, 999950000000, 999999999999));
  EXPECT_THAT(stamps("140007602161411\n"), ElementsAre(140007602161411));
  EXPECT_THAT(stamps("0 140007602161411\n1 140007652161411\n2 140007702161411\n"),
              ElementsAre(140007602161411, 140007652161411, 140007702161411));
  EXPECT_THAT(stamps("0 1400076021614\n1 1400126021614\n"), ElementsAre(1400076021614, 1400126021614))
      << "20 Hz in nanoseconds, and 14 hours apart as milliseconds";
}

TEST_F(Files, NumbersThatCanNotBeStampsAreRefused) {
  const auto problem = [&](const std::string& text) {
    write("times.txt", text);
    const auto read = read_stamps(folder / "times.txt");
    return read ? "" : read.error().message;
  };
  EXPECT_THAT(problem("0.5\n100000000000\n"), AllOf(HasSubstr("times.txt:2"), HasSubstr("'100000000000'")));
  EXPECT_THAT(problem("140007602161411\nx\n"), AllOf(HasSubstr("times.txt:2"), HasSubstr("'x'")));
  EXPECT_THAT(problem("0 100000000000.5\n1 100000000000.6\n"),
              AllOf(HasSubstr("times.txt:1"), HasSubstr("'100000000000.5' is not a stamp"), HasSubstr("the rows")));
  EXPECT_THAT(problem("0 0.5\n1 99999999999999999999\n"), HasSubstr("times.txt:2: '99999999999999999999'"));
}

TEST(Stamps, GoThroughTextUnchanged) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const auto stamp = static_cast<Timestamp>(random.next() >> (2 + random.below(60))) * (random.below(2) ? 1 : -1);
    EXPECT_EQ(parse_stamp(stamp_text(stamp)), stamp);
    EXPECT_EQ(parse_stamp(std::to_string(stamp), WholeStamp::nanoseconds), stamp);
  }
}

}  // namespace
}  // namespace covis::io
