// SPDX-License-Identifier: Apache-2.0
// Small deterministic random number generator. It gives the same numbers on every machine and standard library, which
// the std distributions do not. Seeds come from hash_seed(seed, stage, frame), so that no stage's numbers depend on how
// many another stage drew.
#pragma once

#include <cmath>
#include <cstdint>

namespace covis {

constexpr uint64_t mix64(uint64_t x) {  // the finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014)
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

constexpr uint64_t hash_seed(uint64_t seed, uint64_t stage, uint64_t frame = 0) {
  return mix64(mix64(mix64(seed) ^ stage) ^ frame);
}

// The stages of the library that draw numbers. The tools that train vocabularies and render recordings number their
// own.
enum class RandomStage : uint64_t { mono_initializer = 1, relocalisation = 2, loops = 3 };

constexpr uint64_t hash_seed(uint64_t seed, RandomStage stage, uint64_t frame) {
  return hash_seed(seed, static_cast<uint64_t>(stage), frame);
}

class Random {
 public:
  explicit constexpr Random(uint64_t seed) : state_(seed) {}

  constexpr uint64_t next() {
    const uint64_t value = mix64(state_);
    state_ += 0x9e3779b97f4a7c15ull;
    return value;
  }
  // Uniform in [0, n), n > 0.
  constexpr uint32_t below(uint32_t n) { return static_cast<uint32_t>(((next() >> 32) * n) >> 32); }
  // Uniform in [0, 1).
  constexpr double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  constexpr double uniform(double lo, double hi) { return lo + (hi - lo) * uniform(); }
  // Standard normal (Box-Muller).
  double normal() {
    const double u = 1.0 - uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(6.283185307179586 * uniform());
  }

 private:
  uint64_t state_;
};

}  // namespace covis
