// SPDX-License-Identifier: Apache-2.0
#include "covis/core/message_text.h"

#include <gmock/gmock.h>

namespace covis {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::StartsWith;

TEST(MessageText, GivesTheTerminalNoCommands) {
  EXPECT_EQ(shown("list.txt:3: '\x1b[2J' is no stamp\tsee \x7f"), "list.txt:3: '\\x1b[2J' is no stamp\tsee \\x7f");
  EXPECT_EQ(shown(std::string("a\0b\r", 4)), "a\\x00b\\x0d");
  EXPECT_EQ(shown("caf\xc3\xa9 \xc2\xb1 \xc2\x9b"
                  "31m"),
            "caf\xc3\xa9 \xc2\xb1 \\x9b31m");
  EXPECT_EQ(shown("caf\xe9 \xc2"), "caf\xe9 \xc2") << "names of files need not be UTF-8";
}

TEST(MessageText, HasNoLinesThatInputMade) {
  EXPECT_EQ(shown("camera.yaml:1: width: '3\n\ninfo: all is well' is no number"),
            "camera.yaml:1: width: '3\\x0a\\x0ainfo: all is well' is no number");
  EXPECT_EQ(shown("a library's words\n"), "a library's words");
  const std::string own(kCameraExample);
  EXPECT_EQ(shown("a\nb: a YAML such as:" + own), "a\\x0ab: a YAML such as:" + own);
  const std::string both = std::string(kBagConversion) + "bag" + own;
  EXPECT_EQ(shown(both + "\nc"), both + "\\x0ac");
  EXPECT_EQ(shown_lines("one\n\n\x1btwo\n"), "one\n\n\\x1btwo\n");
}

TEST(MessageText, KeepsBeginningAndEndOfWhatIsVeryLong) {
  const std::string text = "list.txt:3: '" + std::string(100'000, 'x') + "' is not a stamp in seconds";
  EXPECT_THAT(shown(text), AllOf(StartsWith("list.txt:3: 'xxx"), EndsWith("xxx' is not a stamp in seconds")));
  EXPECT_LT(shown(text).size(), 2600u);
  std::string accents;
  for (int i = 0; i < 50'000; ++i) accents += "\xc3\xa9";
  const std::string cut = shown("a" + accents);
  EXPECT_THAT(cut, testing::HasSubstr("\xc3\xa9 … \xc3\xa9")) << "no character is cut in two";
}

}  // namespace
}  // namespace covis
