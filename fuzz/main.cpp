// SPDX-License-Identifier: Apache-2.0
// Built for libFuzzer (the preset `fuzz`), the environment variable COVIS_FUZZ_TARGET names the target that is fuzzed.
// Built otherwise, the program runs files once:
//   covis_fuzz CORPUS            each file of CORPUS/TARGET through its target
//   covis_fuzz TARGET FILE…      these files through the target
//   covis_fuzz --mutate N CORPUS TARGET…   N changed inputs of each of these targets, without a look at what they reach
//   covis_fuzz --seeds CORPUS    writes the inputs to begin with, as CORPUS/TARGET/seedN
//   covis_fuzz --list            prints the targets
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

#include "covis/core/log.h"
#include "covis/core/random.h"
#include "scratch.h"
#include "target.h"

namespace covis::fuzz {
namespace {

const std::vector<Target>& targets() {
  static const std::vector<Target> all = [] {
    set_log_sink([](LogLevel, std::string_view) {});
    std::vector<Target> made;
    for (const auto& some :
         {map_targets(), vocabulary_targets(), text_targets(), recording_targets(), ros_targets(), image_targets()})
      made.insert(made.end(), some.begin(), some.end());
    return made;
  }();
  return all;
}

const Target* find_target(const std::string& name) {
  const auto at = std::find_if(targets().begin(), targets().end(), [&](const Target& t) { return t.name == name; });
  return at == targets().end() ? nullptr : &*at;
}

}  // namespace
}  // namespace covis::fuzz

#ifdef COVIS_FUZZ

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace covis::fuzz;
  static const Target* const target = [] {
    const char* name = std::getenv("COVIS_FUZZ_TARGET");
    const Target* found = find_target(name ? name : "");
    require(found != nullptr, "COVIS_FUZZ_TARGET names no target");
    return found;
  }();
  target->run({reinterpret_cast<const char*>(data), size});
  return 0;
}

#else

namespace covis::fuzz {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

void run(const Target& target, const std::vector<fs::path>& files) {
  for (const fs::path& file : files) {
    std::cout << target.name << " " << file.filename().string() << std::endl;  // the last is the one that fails
    target.run(read_file(file));
  }
}

int run_corpus(const fs::path& corpus) {
  for (const Target& target : targets()) {
    if (!fs::is_directory(corpus / target.name)) {
      std::cerr << (corpus / target.name).string() << ": there is no such folder\n";
      return 1;
    }
    run(target, files_in(corpus / target.name));
  }
  return 0;
}

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
        std::memcpy(bytes.data() + at, &value, std::min<size_t>(bytes.size() - at, size_t{1} << random.below(4)));
        break;
      }
      case 3:
        bytes.erase(at, length);
        break;
      case 4:
        bytes.insert(at, bytes.substr(below(bytes.size() + 1), 1 + below(40)));
        break;
      case 5:
        bytes.insert(at, other.substr(below(other.size() + 1), 1 + below(200)));
        break;
      default: {
        static const std::vector<std::string> kWords{"nan", "inf",  "-1", "1e300", "1e-300", "99999999999999999999",
                                                     "\n",  "\0",   ",",  ": [",   "{",      " 0 0 0 ",
                                                     "/..", "%%\n", "#",  "&a ",   "*a",     "1e308"};
        bytes.replace(at, random.below(2) == 0 ? length : 0, kWords[below(kWords.size())]);
      }
    }
  }
  return bytes;
}

int run_mutated(int64_t count, const fs::path& corpus, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const Target* target = find_target(name);
    if (!target || !fs::is_directory(corpus / name)) {
      std::cerr << name << ": there is no such target with inputs\n";
      return 2;
    }
    std::vector<std::string> inputs;
    for (const fs::path& file : files_in(corpus / name)) inputs.push_back(read_file(file));
    Random random(1);
    for (int64_t i = 0; i < count; ++i) {
      const auto any = [&]() -> const std::string& {
        return inputs[random.below(static_cast<uint32_t>(inputs.size()))];
      };
      const std::string input = mutated(any(), any(), random);
      write_file(scratch_folder() / "input", input);  // left behind by a crash
      target->run(input);
    }
    std::cout << name << ": " << count << " inputs" << std::endl;
  }
  return 0;
}

void write_seeds(const fs::path& corpus) {
  for (const Target& target : targets()) {
    fs::create_directories(corpus / target.name);
    int number = 0;
    for (const std::string& seed : target.seeds())
      write_file(corpus / target.name / ("seed" + std::to_string(number++)), seed);
  }
}

}  // namespace
}  // namespace covis::fuzz

int main(int count, char** values) {
  using namespace covis::fuzz;
  const std::vector<std::string> arguments(values + 1, values + count);
  if (arguments.size() == 1 && arguments[0] == "--list") {
    for (const Target& target : targets()) std::cout << target.name << "\n";
    return 0;
  }
  if (arguments.size() == 2 && arguments[0] == "--seeds") return write_seeds(arguments[1]), 0;
  if (arguments.size() > 3 && arguments[0] == "--mutate")
    return run_mutated(std::atoll(arguments[1].c_str()), arguments[2], {arguments.begin() + 3, arguments.end()});
  if (arguments.size() == 1) return run_corpus(arguments[0]);
  const Target* target = arguments.empty() ? nullptr : find_target(arguments[0]);
  if (!target) {
    std::cerr << "usage: covis_fuzz CORPUS | TARGET FILE… | --seeds CORPUS | --list\n";
    return 2;
  }
  run(*target, {arguments.begin() + 1, arguments.end()});
  return 0;
}

#endif
