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

// Files that OpenCV writes begin so.
TEST_F(Yaml, ADirectiveOfOpenCvIsNoError) {
  write("a.yaml", "%YAML:1.0\n---\none: 1\n");
  const auto loaded = load_yaml(folder / "a.yaml");
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_EQ((*loaded)["one"].as<int>(), 1);
}

}  // namespace
}  // namespace covis::io
