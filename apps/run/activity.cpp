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

void write_error(std::string_view reason) {
  char text[kLongest + 100], message[kLongest + 400];
  describe(text);
  const int length = std::snprintf(message, sizeof message, "error: %s: %.*s", text,
                                   static_cast<int>(std::min<size_t>(reason.size(), 250)), reason.data());
  char* const end = message + std::min(static_cast<size_t>(std::max(0, length)), sizeof message - 2);
  const auto is_control = [](unsigned char c) { return c < ' ' || c == 0x7f; };
  std::replace_if(message, end, is_control, '?');  // the exception's text may quote a file of strangers
  *end = '\n';
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, message, static_cast<size_t>(end + 1 - message));
}

[[noreturn]] void end_in_order() {
  const std::exception_ptr failure = std::current_exception();
  try {
    if (failure) std::rethrow_exception(failure);
    write_error("the process can't go on");
  } catch (const std::exception& error) {
    write_error(reason_of(error));
    if (lack_of_resources(error)) std::_Exit(1);
  } catch (...) {
    write_error("an exception of unknown kind");
  }
  std::abort();
}

}  // namespace

void set_activity(int argc, const char* const* argv) {
  std::string words = "covis";
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) words.append(" ").append(argv[i]);
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
