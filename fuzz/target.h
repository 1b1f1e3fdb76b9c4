// SPDX-License-Identifier: Apache-2.0
// What is fuzzed: readers of what comes from outside. A target takes any bytes; the only wrong outcomes are a crash, a
// finding of a sanitizer, memory or time without bound, and a failed require().
#pragma once

#include <cstdlib>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

namespace covis::fuzz {

struct Target {
  std::string name;  // also of its folder in fuzz/corpus
  void (*run)(std::string_view bytes);
  std::vector<std::string> (*seeds)();  // inputs to begin with, made by the project itself
};

std::vector<Target> map_targets();
std::vector<Target> vocabulary_targets();
std::vector<Target> text_targets();
std::vector<Target> recording_targets();
std::vector<Target> ros_targets();
std::vector<Target> image_targets();

// Ends the process when something holds that must not.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::cerr << "require: " << what << std::endl;
  std::abort();
}

}  // namespace covis::fuzz
