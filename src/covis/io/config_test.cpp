// SPDX-License-Identifier: Apache-2.0
#include "covis/io/config.h"

#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Settings : public RecordingTest {};

TEST_F(Settings, SettingsRoundTripAndComplain) {
  int count = 3;
  double ratio = 0.5;
  const Fields fields{{"a.count", &count, "how many", 1, 10}, {"a.ratio", &ratio, "share", 0, 1}};
  count = 7;
  write("s.yaml", dump_settings(fields));
  count = 1;
  ASSERT_TRUE(load_settings(folder / "s.yaml", fields));
  EXPECT_EQ(count, 7);
  write("s.yaml", "a:\n  count: 2\n  rtaio: 0.1\n");
  EXPECT_THAT(load_settings(folder / "s.yaml", fields).error().message,
              AllOf(HasSubstr("s.yaml:3"), HasSubstr("a.rtaio"), HasSubstr("'a.ratio'")));
  write("s.yaml", "a.count: 99\n");
  EXPECT_THAT(load_settings(folder / "s.yaml", fields).error().message,
              AllOf(HasSubstr("s.yaml:1"), HasSubstr("'99'"), HasSubstr("from 1 to 10")));
}

TEST_F(Settings, EveryKindOfValueIsChecked) {
  int count = 3;
  bool flag = false;
  std::string text("a \"quoted\" \\ word # and:\tmore\n\x16 \0\x7f \xc3\xa4", 37);
  double ratio = 0.1;
  const Fields fields{{"count", &count, "how many", 1, 10},
                      {"part.flag", &flag, "yes or no"},
                      {"part.text", &text, "words"},
                      {"part.ratio", &ratio, "share", 0, 1}};
  const std::string wanted = text;
  const std::string dumped = dump_settings(fields);
  EXPECT_THAT(dumped, AllOf(HasSubstr("# how many; from 1 to 10"), HasSubstr("# share; from 0 to 1")));
  write("s.yaml", dumped);
  text.clear();
  ratio = 0;
  const auto loaded = load_settings(folder / "s.yaml", fields);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(text, wanted);
  EXPECT_EQ(ratio, 0.1);

  const auto error = [&](const std::string& yaml) {
    write("s.yaml", yaml);
    const auto result = load_settings(folder / "s.yaml", fields);
    return result ? "" : result.error().message;
  };
  EXPECT_THAT(error("count: 2.5\n"), AllOf(HasSubstr("s.yaml:1"), HasSubstr("whole number")));
  EXPECT_THAT(error("part:\n  flag: maybe\n"), AllOf(HasSubstr("s.yaml:2"), HasSubstr("true or false")));
  EXPECT_THAT(error("part: {ratio: .nan}\n"), AllOf(HasSubstr("part.ratio"), HasSubstr(".nan")));
  EXPECT_THAT(error("part: {ratio: }\n"), HasSubstr("part.ratio"));
  EXPECT_THAT(error("count: [1, 2]\n"), HasSubstr("single value"));
  EXPECT_THAT(error("count: 1\ncount: 2\n"), AllOf(HasSubstr("s.yaml:2"), HasSubstr("twice")));
  EXPECT_THAT(error("part.flag: true\npart: {flag: true}\n"), HasSubstr("twice"));
  EXPECT_THAT(error("- count\n"), HasSubstr("must be a map"));
  EXPECT_THAT(error("count: {\n"), AllOf(HasSubstr("s.yaml:"), HasSubstr("not YAML")));
  EXPECT_EQ(error(""), "");
}

}  // namespace
}  // namespace covis::io
