// SPDX-License-Identifier: Apache-2.0
// Built for libFuzzer (the preset `fuzz`), the environment variable COVIS_FUZZ_TARGET names the target that is fuzzed.
// Built otherwise, the program runs files once:
//   covis_fuzz CORPUS            each file of CORPUS/TARGET through its target
//   covis_fuzz TARGET FILE…      these files through the target
//   covis_fuzz --new SECONDS SEED CORPUS [TARGET…]   changed inputs, others for each SEED, without a look at what they
//                                reach; the targets share the time, and each has a process of its own
//   covis_fuzz --input SEED NUMBER CORPUS TARGET     writes one of those inputs to the standard output
//   covis_fuzz --seeds CORPUS    writes the inputs to begin with, as CORPUS/TARGET/seedN
//   covis_fuzz --list            prints the targets
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "covis/core/log.h"
#include "new_inputs.h"
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

int run_new_inputs(const std::vector<std::string>& arguments) {
  const double seconds = std::atof(arguments[1].c_str());
  const uint64_t seed = std::strtoull(arguments[2].c_str(), nullptr, 10);
  if (!(seconds > 0)) return std::cerr << arguments[1] << ": a number of seconds is expected\n", 2;
  std::vector<Target> chosen;
  for (size_t i = 4; i < arguments.size(); ++i) {
    const Target* target = find_target(arguments[i]);
    if (!target) return std::cerr << arguments[i] << ": there is no such target\n", 2;
    chosen.push_back(*target);
  }
  if (chosen.empty()) chosen = targets();
  bool failed = false;
  for (const Target& target : chosen) {
    if (!fs::is_directory(arguments[3] + "/" + target.name))
      return std::cerr << arguments[3] << "/" << target.name << ": there is no such folder\n", 2;
    const NewInputs inputs(seed, arguments[3], target.name);
    failed |= !run_for(inputs, target, seconds / static_cast<double>(chosen.size()));
  }
  return failed ? 1 : 0;
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
  if (arguments.size() > 3 && arguments[0] == "--new") return run_new_inputs(arguments);
  if (arguments.size() == 5 && arguments[0] == "--input") {
    std::cout << NewInputs(std::strtoull(arguments[1].c_str(), nullptr, 10), arguments[3], arguments[4])
                     .make(std::strtoull(arguments[2].c_str(), nullptr, 10));
    return 0;
  }
  if (arguments.size() == 1) return run_corpus(arguments[0]);
  const Target* target = arguments.empty() ? nullptr : find_target(arguments[0]);
  if (!target) {
    std::cerr
        << "usage: covis_fuzz CORPUS | TARGET FILE… | --new SECONDS SEED CORPUS [TARGET…] | --input SEED NUMBER CORPUS "
           "TARGET | --seeds CORPUS | --list\n";
    return 2;
  }
  run(*target, {arguments.begin() + 1, arguments.end()});
  return 0;
}

#endif
