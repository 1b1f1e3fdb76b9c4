// SPDX-License-Identifier: Apache-2.0
// The names that the examples of the documentation use without declaring them.
#pragma once

#include <covis/covis.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

inline covis::CameraParameters camera;
inline int64_t stamp_ns = 0;                             // nanoseconds
inline const uint8_t* grey = nullptr;                    // first pixel of an image of 640 x 480
inline const uint8_t *left = nullptr, *right = nullptr;  // the same of a stereo pair
inline const float* depth = nullptr;                     // metres, 640 x 480

template <class... T>
void use(const T&...) {}
inline int report(const std::string& error) { return std::fprintf(stderr, "%s\n", error.c_str()), 1; }
