// SPDX-License-Identifier: Apache-2.0
#include "covis/core/failure_reason.h"

#include <new>
#include <system_error>

namespace covis {
namespace {

bool lacks_memory(const std::exception& error) {
  const auto* const system = dynamic_cast<const std::system_error*>(&error);
  return dynamic_cast<const std::bad_alloc*>(&error) || (system && system->code() == std::errc::not_enough_memory) ||
         std::string_view(error.what()).find("(-4:Insufficient memory)") != std::string_view::npos;
}

}  // namespace

std::optional<std::string_view> lack_of_resources(const std::exception& error) {
  if (lacks_memory(error)) return "the memory has run out (ulimit -v, or what the machine has)";
  const auto* const system = dynamic_cast<const std::system_error*>(&error);
  // Threads are the one thing that is made here and may be had again later.
  if (system && system->code() == std::errc::resource_unavailable_try_again)
    return "no thread could be started: the memory has run out, or there are too many (ulimit -v, ulimit -u)";
  return std::nullopt;
}

std::string_view reason_of(const std::exception& error) {
  return lack_of_resources(error).value_or(std::string_view(error.what()));
}

}  // namespace covis
