// SPDX-License-Identifier: Apache-2.0
#include "apps/view/page.h"

#include "covis/eval/charts.h"

#ifdef COVIS_PAGE_FOLDER
// Each file lies between two symbols.
#define COVIS_EMBED(NAME, FILE)                                       \
  asm(".section .rodata\n"                                            \
      ".global covis_" #NAME "_begin\n.global covis_" #NAME           \
      "_end\n"                                                        \
      "covis_" #NAME "_begin:\n.incbin \"" COVIS_PAGE_FOLDER "/" FILE \
      "\"\n"                                                          \
      "covis_" #NAME "_end:\n.byte 0\n.previous\n");                  \
  extern "C" const char covis_##NAME##_begin[], covis_##NAME##_end[];
COVIS_EMBED(html, "index.html")
COVIS_EMBED(script, "viewer.js")
COVIS_EMBED(style, "viewer.css")
#define COVIS_EMBEDDED(NAME) \
  { covis_##NAME##_begin, static_cast<size_t>(covis_##NAME##_end - covis_##NAME##_begin) }
#else
#define COVIS_EMBEDDED(NAME) \
  {}
#endif

namespace covis::view {

bool has_page() { return !page_html().empty(); }
std::string_view page_html() { return COVIS_EMBEDDED(html); }
std::string_view page_script() { return COVIS_EMBEDDED(script); }
std::string_view page_style() { return COVIS_EMBEDDED(style); }

std::string embedded_page(const ViewState& state) {
  if (!has_page()) return {};
  Sent nothing;
  std::string html = "<style>";
  html += page_style();
  html +=
      "</style>\n<div class=\"covis-viewer embedded\" id=\"covis-viewer\"></div>\n"
      "<script type=\"application/octet-stream\" id=\"covis-scene\">";
  html += base64(message_since(state, nothing));
  html += "</script>\n<script>";
  html += page_script();
  html += "</script>\n";
  return html;
}

}  // namespace covis::view
