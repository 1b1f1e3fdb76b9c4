// SPDX-License-Identifier: Apache-2.0
// COVIS_API marks the symbols that libcovis exports to programs that link it; all others are hidden.
#pragma once

#define COVIS_API __attribute__((visibility("default")))
