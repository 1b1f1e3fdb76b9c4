// SPDX-License-Identifier: Apache-2.0
#include "new_inputs.h"

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <iterator>
#include <new>
#include <system_error>

#include "covis/core/random.h"
#include "scratch.h"

namespace covis::fuzz {
namespace {

// Time that one input may take. libFuzzer's 5 are for a machine that does nothing else.
constexpr unsigned kMostSeconds = 20;
constexpr uint64_t kStage = 200;  // stage of random numbers, above those of the library

// One to eight changes: bytes and numbers of other values, pieces moved, doubled, left out, or of another input.
std::string mutated(std::string bytes, const std::string& other, Random& random) {
  constexpr uint64_t kValues[] = {0, 1, 0x7f, 0x80, 0xff, 0x7fffffff, 0x80000000, 0xffffffff, UINT64_MAX, 1u << 20};
  const auto below = [&](size_t n) { return n == 0 ? 0 : random.below(static_cast<uint32_t>(n)); };
  for (uint32_t change = 0, changes = 1 + random.below(8); change < changes; ++change) {
    const size_t at = below(bytes.size() + 1), length = std::min<size_t>(bytes.size() - at, 1 + below(40));
    switch (random.below(7)) {
      case 0:
        if (at < bytes.size()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
        break;
      case 1:
        for (size_t i = 0; i < length; ++i) bytes[at + i] = static_cast<char>(random.below(256));
        break;
      case 2: {
        const uint64_t value = kValues[below(std::size(kValues))];
        const size_t size = size_t{1} << random.below(4);
        std::memcpy(bytes.data() + at, &value, std::min(bytes.size() - at, size));
        break;
      }
      case 3:
        bytes.erase(at, length);
        break;
      case 4: {  // numbers are drawn one after the other: the order of a call's arguments is the compiler's
        const size_t from = below(bytes.size() + 1);
        bytes.insert(at, bytes.substr(from, 1 + below(40)));
        break;
      }
      case 5: {
        const size_t from = below(other.size() + 1);
        bytes.insert(at, other.substr(from, 1 + below(200)));
        break;
      }
      default: {
        static const std::vector<std::string> kWords{"nan",    "inf",
                                                     "-1",     "1e300",
                                                     "1e-300", "99999999999999999999",
                                                     "\n",     std::string(1, '\0'),
                                                     ",",      ": [",
                                                     "{",      " 0 0 0 ",
                                                     "/..",    "%%\n",
                                                     "#",      "&a ",
                                                     "*a",     "1e308"};
        const size_t replaced = random.below(2) == 0 ? length : 0;
        bytes.replace(at, replaced, kWords[below(kWords.size())]);
      }
    }
  }
  return bytes;
}

}  // namespace

NewInputs::NewInputs(uint64_t seed, const std::filesystem::path& corpus, const std::string& target)
    : seed_(seed), corpus_(corpus) {
  for (const std::filesystem::path& file : files_in(corpus / target)) kept_.push_back(read_file(file));
  require(!kept_.empty(), "a corpus with kept inputs of the target");
}

std::string NewInputs::make(uint64_t number) const {
  Random random(hash_seed(seed_, kStage, number));
  const auto any = [&]() -> const std::string& { return kept_[random.below(static_cast<uint32_t>(kept_.size()))]; };
  const std::string& other = any();
  return mutated(any(), other, random);
}

bool run_for(const NewInputs& inputs, const Target& target, double seconds) {
  using Number = std::atomic<uint64_t>;  // shared with the process that runs them
  void* shared = ::mmap(nullptr, sizeof(Number), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  require(shared != MAP_FAILED, "memory for a number");
  auto& number = *new (shared) Number(0);
  const pid_t child = ::fork();
  require(child >= 0, "a process");
  if (child == 0) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    for (; std::chrono::steady_clock::now() < end; ++number) {
      const std::string input = inputs.make(number);
      ::alarm(kMostSeconds);
      target.run(input);
    }
    ::alarm(0);
    std::exit(0);  // leaks are looked for
  }
  int status = 0;
  require(::waitpid(child, &status, 0) == child, "the end of the process");
  std::error_code none;
  std::filesystem::remove_all(scratch_folder_of(child), none);
  const uint64_t reached = number;
  ::munmap(shared, sizeof(Number));
  std::cout << target.name << ": " << reached << " inputs" << std::endl;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return true;
  std::cerr << target.name << ": "
            << (WIFSIGNALED(status) ? "signal " + std::to_string(WTERMSIG(status))
                                    : "exit code " + std::to_string(WEXITSTATUS(status)))
            << "; the input (of a leak, one before it) is made again by\n  covis_fuzz --input " << inputs.seed() << " "
            << reached << " " << inputs.corpus().string() << " " << target.name << " > FILE" << std::endl;
  return false;
}

}  // namespace covis::fuzz
