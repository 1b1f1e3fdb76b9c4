// SPDX-License-Identifier: Apache-2.0
#include "covis/io/yaml.h"

#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::HasSubstr;

class Yaml : public RecordingTest {};

TEST_F(Yaml, NodesKnowTheirLine) {
  write("a.yaml", "# a comment\none: 1\n\ntwo:\n  three: 3\n");
  const auto loaded = load_yaml(folder / "a.yaml");
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ(yaml_place("a.yaml", (*loaded)["one"]), "a.yaml:2");
  EXPECT_EQ(yaml_place("a.yaml", (*loaded)["two"]["three"]), "a.yaml:5");
}

TEST_F(Yaml, ErrorsNameFileAndLine) {
  write("a.yaml", "one: 1\ntwo: [1\n");
  EXPECT_THAT(load_yaml(folder / "a.yaml").error().message, HasSubstr("a.yaml:"));
  EXPECT_THAT(load_yaml(folder / "none.yaml").error().message, HasSubstr("none.yaml"));
}

// YAML::Node would follow it for ever.
TEST_F(Yaml, ANodeThatContainsItselfIsRefused) {
  write("map.yaml", "one: 1\ntwo: &a\n  three: *a\n");
  EXPECT_THAT(load_yaml(folder / "map.yaml").error().message, HasSubstr("map.yaml:3: not YAML that can be read: what"));
  write("list.yaml", "two: &a [[1, *a]]\n");
  EXPECT_THAT(load_yaml(folder / "list.yaml").error().message, HasSubstr("list.yaml:1: "));
  write("good.yaml", "two: &a [1]\nthree: *a\n");
  EXPECT_TRUE(load_yaml(folder / "good.yaml"));
}

// The first value would count, without a word.
TEST_F(Yaml, AKeyThatAMapHasTwiceIsRefused) {
  write("twice.yaml", "one: {a: 1, b: [1, a]}\ntwo:\n  a: 1\n  'a': 2\n");
  EXPECT_THAT(load_yaml(folder / "twice.yaml").error().message, HasSubstr("twice.yaml:4: 'a' is given twice"));
  write("good.yaml", "a: {a: a}\nb: &b [a, a, {a: }]\n? [c, c]\n: d\nc: *b\nd: *b\n");
  EXPECT_TRUE(load_yaml(folder / "good.yaml"));
}

TEST_F(Yaml, ListsThatAliasesMultiplyAreBounded) {
  std::string text = "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (char name = 'b'; name < 'j'; ++name) {
    const std::string before = std::string("*") + static_cast<char>(name - 1);
    text += std::string(1, name) + ": &" + name + " [";
    for (int k = 0; k < 9; ++k) text += (k > 0 ? ", " : "") + before;
    text += "]\n";
  }
  write("bomb.yaml", text);
  const auto loaded = load_yaml(folder / "bomb.yaml");
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_THAT(yaml_numbers("bomb.yaml", *loaded, "i", 4).error().message, HasSubstr("i has more than 1000 numbers"));
}

TEST_F(Yaml, WhatIsNoTextOrTooDeepIsSaid) {
  write("deep.yaml", std::string(5000, '['));
  EXPECT_THAT(load_yaml(folder / "deep.yaml").error().message,
              HasSubstr("deep.yaml:1: not YAML that can be read: it "));
  write("image.yaml", std::string("\x89PNG\r\n\x1a\n\0\0\0\r", 12));
  EXPECT_THAT(load_yaml(folder / "image.yaml").error().message, HasSubstr("image.yaml: not YAML: it is no text"));
  write("wide.yaml", std::string("\xff\xfe"
                                 "a\0:\0 \0"
                                 "1\0",
                                 10));
  const auto wide = load_yaml(folder / "wide.yaml");
  ASSERT_TRUE(wide) << wide.error().message;
  EXPECT_EQ((*wide)["a"].as<int>(), 1);
}

// The second document would be passed over without a word. An empty one, as rostopic prints it, does no harm.
TEST_F(Yaml, ASecondDocumentIsRefusedWhereOneIsExpected) {
  write("two.yaml", "one: 1\n---\none: 2\n");
  EXPECT_TRUE(load_yaml(folder / "two.yaml"));
  EXPECT_THAT(load_only_yaml(folder / "two.yaml").error().message, HasSubstr("two.yaml:3: a second document"));
  write("one.yaml", "---\none: 1\n---\n");
  EXPECT_TRUE(load_only_yaml(folder / "one.yaml"));
}

// Files that OpenCV writes begin so.
// yaml-cpp makes one empty document after the other of it, without end.
TEST_F(Yaml, WhereNoValueCanBeginReadingEnds) {
  write("comma.yaml", ",width: 64\n");
  EXPECT_THAT(load_only_yaml(folder / "comma.yaml").error().message,
              HasSubstr("comma.yaml:1: not YAML: no value begins"));
  write("later.yaml", "width: 64\n%%\n,1\n");
  EXPECT_THAT(load_only_yaml(folder / "later.yaml").error().message, HasSubstr("later.yaml:3: "));
}

TEST_F(Yaml, ADirectiveOfOpenCvIsNoError) {
  write("b.yaml", "\xef\xbb\xbf%YAML:1.0\n---\none: 1\n");
  EXPECT_TRUE(load_yaml(folder / "b.yaml")) << "behind a byte order mark";
  write("a.yaml", "%YAML:1.0\n---\none: 1\n");
  const auto loaded = load_yaml(folder / "a.yaml");
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ((*loaded)["one"].as<int>(), 1);
}

}  // namespace
}  // namespace covis::io
