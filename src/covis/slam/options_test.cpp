// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/options.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

namespace covis {
namespace {

TEST(SystemOptions, EveryFieldIsNamedOnceWithItsMeaning) {
  SystemOptions options;
  std::set<std::string> names;
  for (const Field& field : fields(options)) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name << " stands twice";
    EXPECT_THAT(field.name, testing::MatchesRegex("(orb|tracker|mapper|loop|system)\\.[a-z_]+"));
    EXPECT_GE(field.doc.size(), 8u) << field.name;
  }
  EXPECT_GE(names.size(), 40u);
}

TEST(SystemOptions, EveryNumberHasARangeThatHoldsItsDefault) {
  SystemOptions options;
  for (const Field& field : fields(options)) {
    if (std::holds_alternative<bool*>(field.value) || std::holds_alternative<std::string*>(field.value)) continue;
    EXPECT_NE(field_range(field), "") << field.name;
    EXPECT_GT(field.min, std::numeric_limits<double>::lowest()) << field.name;
    EXPECT_LT(field.max, std::numeric_limits<double>::max()) << field.name;
    const double value =
        std::holds_alternative<int*>(field.value) ? *std::get<int*>(field.value) : *std::get<double*>(field.value);
    EXPECT_TRUE((value >= field.min && value <= field.max) || value == field.also) << field.name;
  }
}

TEST(SystemOptions, EveryFieldSurvivesAsTextAndRefusesWhatIsOutOfRange) {
  SystemOptions written, read;
  Fields from = fields(written);
  const Fields to = fields(read);
  ASSERT_EQ(from.size(), to.size());
  for (size_t i = 0; i < from.size(); ++i) {
    const Field& field = from[i];
    if (auto* const* flag = std::get_if<bool*>(&field.value)) **flag = !**flag;
    if (auto* const* whole = std::get_if<int*>(&field.value))
      **whole += static_cast<double>(**whole) + 1 <= field.max ? 1 : -1;
    if (auto* const* real = std::get_if<double*>(&field.value)) {
      const double from_value = std::max(**real, field.min);
      **real = from_value + (field.max - from_value) / 3;
    }
    const std::string text = field_text(field);
    EXPECT_NE(field_text(to[i]), text) << field.name << " was not changed, or two fields share a place";
    const auto set = set_field(to, field.name, text);
    EXPECT_TRUE(set) << set.error().message;
    EXPECT_EQ(field_text(to[i]), text);
    if (std::holds_alternative<bool*>(field.value)) continue;
    EXPECT_FALSE(set_field(to, field.name, std::to_string(field.max + 1))) << field.name;
    EXPECT_FALSE(set_field(to, field.name, std::to_string(field.min - 1))) << field.name;
    EXPECT_EQ(field_text(to[i]), text) << "changed by what was refused";
  }
}

}  // namespace
}  // namespace covis
