// SPDX-License-Identifier: Apache-2.0
// NumPy's array files (.npy), as depth comes in them: two dimensions of 32-bit floats, little-endian, in C order.
// Source: the format's description, numpy.org/doc/stable/reference/generated/numpy.lib.format.html.
#pragma once

#include <string>
#include <string_view>

#include "covis/core/error.h"
#include "covis/core/image.h"

namespace covis::io {

// Reads the bytes of a file of version 1.0 or 2.0. Errors begin with the name and name the field of the header. Values
// are taken as they are, those that are no numbers too.
Result<void> parse_npy(const std::string& name, std::string_view bytes, ImageF& array);

}  // namespace covis::io
