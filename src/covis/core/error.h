// SPDX-License-Identifier: Apache-2.0
// Expected failures (files, configuration, images) are values: Result<T> holds a T or an Error whose message names the
// file, the field, the value, and what would be right (architecture.md, decision 8). Programming errors are assertions.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace covis {

struct Error {
  std::string message;
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(std::string message) { return tl::unexpected<Error>(Error{std::move(message)}); }

}  // namespace covis
