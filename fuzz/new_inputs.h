// SPDX-License-Identifier: Apache-2.0
// Inputs made of kept ones by random changes, for a look around without libFuzzer: by any compiler and preset.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "target.h"

namespace covis::fuzz {

// The inputs of one target. Input n depends on the seed, n, and the kept files alone.
class NewInputs {
 public:
  // `corpus` has a folder of the target's name with the kept inputs.
  NewInputs(uint64_t seed, const std::filesystem::path& corpus, const std::string& target);
  std::string make(uint64_t number) const;
  uint64_t seed() const { return seed_; }
  const std::filesystem::path& corpus() const { return corpus_; }

 private:
  uint64_t seed_;
  std::filesystem::path corpus_;
  std::vector<std::string> kept_;
};

// Runs inputs 0, 1, … in a process of its own until the time is over; false, with a message that says how to make the
// input again, if it ends before: by a signal, a sanitizer or because an input takes 20 seconds.
bool run_for(const NewInputs& inputs, const Target& target, double seconds);

}  // namespace covis::fuzz
