// SPDX-License-Identifier: Apache-2.0
#include "apps/view/page.h"

#include <gmock/gmock.h>

#include "apps/view/test_scene.h"

namespace covis::view {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Page, IsWholeInItself) {
  if (!has_page()) GTEST_SKIP() << "built without the viewer";
  EXPECT_THAT(std::string(page_html()), HasSubstr("viewer.js"));
  EXPECT_THAT(std::string(page_style()), HasSubstr(".covis-viewer"));
  // The page fetches nothing from elsewhere.
  for (const auto part : {page_html(), page_style()}) EXPECT_THAT(std::string(part), Not(HasSubstr("http")));
}

TEST(Page, TheEmbeddedOneHoldsItsSceneAndNoEndOfAScriptButItsOwn) {
  if (!has_page()) GTEST_SKIP() << "built without the viewer";
  ViewState state;
  state.info = R"({"title":"</script>"})";
  state.map = std::make_shared<const MapScene>(scene_of(small_snapshot()));
  const std::string html = embedded_page(state);
  EXPECT_THAT(html, HasSubstr("id=\"covis-scene\""));
  size_t ends = 0;
  for (size_t at = html.find("</script"); at != std::string::npos; at = html.find("</script", at + 1)) ++ends;
  EXPECT_EQ(ends, 2u);
}

}  // namespace
}  // namespace covis::view
