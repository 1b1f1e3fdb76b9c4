// SPDX-License-Identifier: Apache-2.0
// The viewer's page (web/), which is built into the command.
#pragma once

#include <string>
#include <string_view>

#include "apps/view/view_state.h"

namespace covis::view {

// False when the command was built without the viewer (-DCOVIS_VIEWER=OFF).
bool has_page();

std::string_view page_html();
std::string_view page_script();
std::string_view page_style();

// HTML that shows this state within another page, for itself and without a server; empty without the viewer.
// Observations are left out.
std::string embedded_page(const ViewState& state);

}  // namespace covis::view
