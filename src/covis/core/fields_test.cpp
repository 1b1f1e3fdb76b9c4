// SPDX-License-Identifier: Apache-2.0
#include "covis/core/fields.h"

#include <gmock/gmock.h>

namespace covis {
namespace {

using testing::HasSubstr;

struct Options {
  int count = 3;
  double ratio = 0.5;
  bool fast = false;
  std::string label = "a";
};

Fields fields(Options& o) {
  return {{"test.count", &o.count, "how many", 1, 10},
          {"test.ratio", &o.ratio, "share", 0, 1},
          {"test.fast", &o.fast, "speed"},
          {"test.label", &o.label, "name"}};
}

TEST(Fields, SetsEveryKind) {
  Options o;
  const Fields f = fields(o);
  EXPECT_TRUE(set_field(f, "test.count", "7"));
  EXPECT_TRUE(set_field(f, "test.ratio", "0.25"));
  EXPECT_TRUE(set_field(f, "test.fast", "true"));
  EXPECT_TRUE(set_field(f, "test.label", "b c"));
  EXPECT_EQ(o.count, 7);
  EXPECT_EQ(o.ratio, 0.25);
  EXPECT_TRUE(o.fast);
  EXPECT_EQ(o.label, "b c");
}

TEST(Fields, TextRoundTrips) {
  Options o, copy;
  o.count = 9;
  o.ratio = 0.1;
  o.fast = true;
  o.label = "z";
  const Fields from = fields(o), to = fields(copy);
  for (const Field& field : from) ASSERT_TRUE(set_field(to, field.name, field_text(field)));
  EXPECT_EQ(copy.count, 9);
  EXPECT_EQ(copy.ratio, 0.1);
  EXPECT_TRUE(copy.fast);
  EXPECT_EQ(copy.label, "z");
}

TEST(Fields, RefusesWhatIsNotRightAndChangesNothing) {
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{{"test.count", "0"},
                                                                                   {"test.count", "11"},
                                                                                   {"test.count", "2.5"},
                                                                                   {"test.count", "two"},
                                                                                   {"test.count", ""},
                                                                                   {"test.ratio", "nan"},
                                                                                   {"test.ratio", "1.5"},
                                                                                   {"test.ratio", "inf"},
                                                                                   {"test.fast", "yes"}}) {
    Options o;
    const auto result = set_field(fields(o), name, text);
    ASSERT_FALSE(result) << name << "=" << text;
    EXPECT_THAT(result.error().message, HasSubstr(name));
    EXPECT_EQ(o.count, 3);
    EXPECT_EQ(o.ratio, 0.5);
    EXPECT_FALSE(o.fast);
  }
}

TEST(Fields, MessageNamesTheRange) {
  Options o;
  EXPECT_THAT(set_field(fields(o), "test.count", "11").error().message, HasSubstr("from 1 to 10"));
}

TEST(Fields, AValueOfItsOwnMeaningIsAllowedOutsideOfTheRange) {
  double seconds = 0;
  const Fields listed{{"test.seconds", &seconds, "seconds; -1: they are found", -0.2, 0.2, {}, -1}};
  EXPECT_TRUE(set_field(listed, "test.seconds", "-1"));
  EXPECT_EQ(seconds, -1);
  EXPECT_TRUE(set_field(listed, "test.seconds", "-0.2"));
  EXPECT_THAT(set_field(listed, "test.seconds", "-0.9").error().message, HasSubstr("from -0.2 to 0.2, or -1"));
  EXPECT_EQ(seconds, -0.2);
}

TEST(Fields, UnknownNameGivesTheNearest) {
  Options o;
  const auto result = set_field(fields(o), "test.cuont", "3");
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, HasSubstr("'test.count'"));
}

TEST(NearestName, CountsLetters) {
  EXPECT_EQ(nearest_name("widht", {"height", "width", "depth"}), "width");
  EXPECT_EQ(nearest_name("x", {}), "");
}

}  // namespace
}  // namespace covis
