// SPDX-License-Identifier: Apache-2.0
// Lines of numbers, each as short as it can be read back exactly.
#pragma once

#include <charconv>
#include <string>
#include <string_view>

namespace covis::exchange {

class Text {
 public:
  // Appends words and numbers, with a space between two of them.
  template <class... Values>
  Text& operator()(const Values&... values) {
    (add(values), ...);
    return *this;
  }
  void end_line() {
    if (!text_.empty() && text_.back() == ' ') text_.pop_back();
    text_ += '\n';
  }
  template <class... Values>
  void line(const Values&... values) {
    (*this)(values...).end_line();
  }
  std::string take() { return std::move(text_); }

 private:
  void add(std::string_view word) { text_.append(word).push_back(' '); }
  void add(const char* word) { add(std::string_view(word)); }
  void add(const std::string& word) { add(std::string_view(word)); }
  template <class Number>
  void add(Number number) {
    char digits[40];
    const auto end = std::to_chars(digits, digits + sizeof digits, number).ptr;
    add(std::string_view(digits, static_cast<size_t>(end - digits)));
  }

  std::string text_;
};

}  // namespace covis::exchange
