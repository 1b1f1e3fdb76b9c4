// SPDX-License-Identifier: Apache-2.0
#include "apps/run/activity.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string_view>

#include "covis/core/failure_reason.h"
#include "covis/core/message_text.h"

namespace covis::app {
namespace {

constexpr size_t kLongest = 600;
char command_words[kLongest] = "covis";  // written before there are threads
std::atomic<const char*> current_part = nullptr;
std::atomic<int64_t> current_frame = -1;

// Takes no memory, of which there may be none.
void describe(char (&text)[kLongest + 100]) {
  const char* const part = current_part;
  if (const int64_t frame = current_frame; frame >= 0) {
    std::snprintf(text, sizeof text, "%s, frame %lld", command_words, static_cast<long long>(frame));
  } else {
    std::snprintf(text, sizeof text, "%s%s%s", command_words, part ? ", " : "", part ? part : "");
  }
}

[[noreturn]] void end_in_order() {
  char text[kLongest + 100], message[kLongest + 400];
  describe(text);
  std::string_view reason = "the process can't go on";
  const std::exception_ptr failure = std::current_exception();  // held, as the reason may be its text
  try {
    if (failure) std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    reason = reason_of(error);
  } catch (...) {
  }
  const int length = std::snprintf(message, sizeof message, "error: %s: %.*s\n", text,
                                   static_cast<int>(std::min<size_t>(reason.size(), 250)), reason.data());
  const auto bytes = std::min(static_cast<size_t>(std::max(0, length)), sizeof message - 1);
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, message, bytes);
  std::_Exit(1);
}

}  // namespace

void set_activity(int argc, const char* const* argv) {
  std::string words = "covis";
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) words += " " + std::string(argv[i]);
  std::snprintf(command_words, sizeof command_words, "%s", shown(words).c_str());
}

void enter_part(const char* part) {
  current_frame = -1;
  current_part = part;
}

void enter_frame(int64_t frame) { current_frame = frame; }

std::string current_activity() {
  char text[kLongest + 100];
  describe(text);
  return text;
}

void end_in_order_on_terminate() { std::set_terminate(end_in_order); }

}  // namespace covis::app
