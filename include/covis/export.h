// SPDX-License-Identifier: Apache-2.0
// COVIS_API marks what libcovis shows to programs that link it; everything else in it is hidden.
#pragma once

#define COVIS_API __attribute__((visibility("default")))
