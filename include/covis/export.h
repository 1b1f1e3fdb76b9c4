// SPDX-License-Identifier: Apache-2.0
// COVIS_API marks the symbols that libcovis exports to programs that link it; all others are hidden. COVIS_HIDDEN marks
// what is hidden inside a class that is exported.
#pragma once

#define COVIS_API __attribute__((visibility("default")))
#define COVIS_HIDDEN __attribute__((visibility("hidden")))
