// SPDX-License-Identifier: Apache-2.0
// Exceptions in words for people: which resource is at its end, and what limits it.
#pragma once

#include <exception>
#include <optional>
#include <string_view>

namespace covis {

// The reason where memory or threads have run out, which is no fault of the program's; else nullopt.
std::optional<std::string_view> lack_of_resources(const std::exception& error);

// The exception's own text, except for a lack of memory (also where OpenCV reports it) or of threads. It takes no
// memory, and is valid as long as the exception.
std::string_view reason_of(const std::exception& error);

}  // namespace covis
