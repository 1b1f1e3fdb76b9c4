// SPDX-License-Identifier: Apache-2.0
// covis vocab train | info | convert: vocabularies for place recognition.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "commands.h"
#include "common.h"
#include "covis/core/log.h"
#include "covis/core/time.h"
#include "covis/io/output_check.h"
#include "covis/vocabulary/train.h"
#include "covis/vocabulary/vocabulary.h"
#include "training_images.h"

namespace covis::app {
namespace {

struct TrainArguments {
  TrainOptions options;
  OrbOptions orb;
  std::map<std::string, std::string> settings;  // field name to text, for the given flags
  std::vector<std::string> inputs;
  std::string out;
  bool overwrite = false, quiet = false, json = false;
};

struct FileArguments {
  std::string in, out;
  bool overwrite = false, json = false;
};

Fields train_fields(TrainArguments& arguments) {
  Fields all = fields(arguments.options);
  for (const Field& field : fields(arguments.orb)) {
    if (field.name == "orb.features") all.push_back(field);
  }
  return all;
}

std::string checksum_text(uint64_t checksum) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(checksum));
  return text;
}

Result<void> may_write(const std::string& file, bool overwrite, const std::vector<std::string>& inputs) {
  std::error_code error;
  if (!overwrite && std::filesystem::exists(file, error))
    return fail(file + ": the file exists; --overwrite replaces it");
  const auto fits = io::check_output(file, io::OutputKind::vocabulary, {inputs.begin(), inputs.end()});
  if (!fits) return fits;
  const std::filesystem::path folder = std::filesystem::absolute(file, error).parent_path();
  if (!std::filesystem::is_directory(folder, error)) return fail(folder.string() + ": there is no such folder");
  return {};
}

// A line on a terminal that is updated in place.
class ProgressLine {
 public:
  explicit ProgressLine(std::FILE* out) : out_(out) {}  // nullptr: not shown
  ~ProgressLine() {
    if (begun_) std::fputs("\n", out_);
  }
  // Returns false when the user asked to stop.
  bool operator()(const char* what, double done) {
    if (out_ != nullptr && (!begun_ || since_.ms() >= 100 || done >= 1)) {
      since_.restart();
      begun_ = true;
      std::fprintf(out_, "\r\033[K%s %.0f %%  %.0f s", what, 100 * done, all_.ms() / 1000);
      std::fflush(out_);
    }
    return interrupted == 0;
  }

 private:
  std::FILE* out_;
  bool begun_ = false;
  Stopwatch all_, since_;
};

nlohmann::json summary_of(const Vocabulary& vocabulary, const std::string& file) {
  std::error_code error;
  return {{"file", file},
          {"branching", vocabulary.branching()},
          {"depth", vocabulary.depth()},
          {"words", vocabulary.words()},
          {"nodes", vocabulary.nodes()},
          {"checksum", checksum_text(vocabulary.checksum())},
          {"bytes", static_cast<uint64_t>(std::filesystem::file_size(file, error))}};
}

void print_training(const TrainArguments& arguments, const Vocabulary& vocabulary, const TrainingSet& set, size_t files,
                    const ExtractionReport& report, double extraction_s, double training_s) {
  const size_t images = files - report.skipped.size();
  nlohmann::json summary = summary_of(vocabulary, arguments.out);
  summary["images"] = images;
  summary["passed_over"] = report.skipped.size();
  summary["pieces"] = set.images();
  summary["descriptors"] = set.seen();
  summary["descriptors_used"] = set.descriptors().size();
  summary["extraction_s"] = extraction_s;
  summary["training_s"] = training_s;
  if (arguments.json) {
    print_json(summary);
  } else if (!arguments.quiet) {
    std::printf(
        "%zu images in %zu pieces, %zu of %zu descriptors used (%.1f s); %u words of branching %d and depth %d "
        "(%.1f s) in %s, checksum %s\n",
        images, static_cast<size_t>(set.images()), set.descriptors().size(), static_cast<size_t>(set.seen()),
        extraction_s, vocabulary.words(), vocabulary.branching(), vocabulary.depth(), training_s, arguments.out.c_str(),
        checksum_text(vocabulary.checksum()).c_str());
  }
}

int train(TrainArguments arguments) {
  for (const auto& [name, text] : arguments.settings) {
    if (text.empty()) continue;
    if (auto ok = set_field(train_fields(arguments), name, text); !ok) return fail_with(ok.error());
  }
  if (auto ok = may_write(arguments.out, arguments.overwrite, arguments.inputs); !ok) return fail_with(ok.error());
  const auto files = find_images(arguments.inputs);
  if (!files) return fail_with(files.error());
  end_well_on_signals();

  const TrainOptions& options = arguments.options;
  const bool shown = !arguments.quiet && isatty(STDERR_FILENO);
  TrainingSet set(options.memory_mb, options.seed);
  const Stopwatch extraction;
  ExtractionReport report;
  {
    ProgressLine progress(shown ? stderr : nullptr);
    report = extract_images(*files, arguments.orb, options.threads, set, [&](size_t done) {
      return progress("images", static_cast<double>(done) / static_cast<double>(files->size()));
    });
  }
  if (report.stopped) {
    fail_with("stopped; nothing was written");
    return 128 + interrupted;
  }
  if (!report.skipped.empty()) {
    log(LogLevel::warning, std::to_string(report.skipped.size()) + " of " + std::to_string(files->size()) +
                               " images were skipped, the first because: " + report.skipped.front());
  }
  const double extraction_s = extraction.ms() / 1000;
  const Stopwatch training;
  Result<std::shared_ptr<const Vocabulary>> vocabulary;
  {
    ProgressLine progress(shown ? stderr : nullptr);
    vocabulary = train_vocabulary(set.descriptors(), set.offsets(), options,
                                  [&](double done) { return progress("training", done); });
  }
  if (!vocabulary) return fail_with(vocabulary.error());
  if (auto ok = (*vocabulary)->save(arguments.out); !ok) return fail_with(ok.error());

  print_training(arguments, **vocabulary, set, files->size(), report, extraction_s, training.ms() / 1000);
  return 0;
}

int info(const FileArguments& arguments) {
  const Stopwatch watch;
  const auto vocabulary = Vocabulary::load(arguments.in);
  const double load_ms = watch.ms();
  if (!vocabulary) return fail_with(vocabulary.error());
  nlohmann::json summary = summary_of(**vocabulary, arguments.in);
  summary["whole"] = true;  // loading has checked it
  summary["load_ms"] = load_ms;
  if (arguments.json) {
    print_json(summary);
  } else {
    std::printf("%s: %u words, %u nodes, branching %d, depth %d, %.1f MB, checksum %s, loaded in %.2f ms\n",
                arguments.in.c_str(), (*vocabulary)->words(), (*vocabulary)->nodes(), (*vocabulary)->branching(),
                (*vocabulary)->depth(), summary["bytes"].get<double>() / 1e6,
                checksum_text((*vocabulary)->checksum()).c_str(), load_ms);
  }
  return 0;
}

int convert(const FileArguments& arguments) {
  if (auto ok = may_write(arguments.out, arguments.overwrite, {arguments.in}); !ok) return fail_with(ok.error());
  const auto vocabulary = Vocabulary::load(arguments.in);
  if (!vocabulary) return fail_with(vocabulary.error());
  const bool text = std::filesystem::path(arguments.out).extension() == ".txt";
  const auto saved = text ? (*vocabulary)->save_text(arguments.out) : (*vocabulary)->save(arguments.out);
  return saved ? 0 : fail_with(saved.error());
}

void add_train(CLI::App& vocab, int& exit_code) {
  auto arguments = std::make_shared<TrainArguments>();
  CLI::App* command = vocab.add_subcommand("train", "Train a vocabulary from images");
  command->add_option("IMAGES", arguments->inputs, "image files, or folders of them")->required();
  for (const Field& field : train_fields(*arguments)) {
    command->add_option("--" + field.name.substr(field.name.find('.') + 1), arguments->settings[field.name], field.doc)
        ->default_str(field_text(field))
        ->type_name("NUMBER");
  }
  command->add_option("--out", arguments->out, "file for the vocabulary")->required();
  command->add_flag("--overwrite", arguments->overwrite, "replace the file");
  command->add_flag("--quiet", arguments->quiet, "no progress, no summary");
  command->add_flag("--json", arguments->json, "the summary as JSON on stdout");
  command->footer("Examples:\n  covis vocab train photographs --branching 10 --depth 5 --out mine.covis-voc");
  command->callback([arguments, &exit_code] { exit_code = train(*arguments); });
}

}  // namespace
}  // namespace covis::app

void add_vocab_command(CLI::App& app, int& exit_code) {
  CLI::App* vocab = app.add_subcommand("vocab", "Train, inspect or convert a vocabulary for recognising places");
  vocab->require_subcommand(1);
  covis::app::add_train(*vocab, exit_code);
  auto arguments = std::make_shared<covis::app::FileArguments>();
  CLI::App* info_command = vocab->add_subcommand("info", "Describe a vocabulary and check its integrity");
  info_command->add_option("FILE", arguments->in, "vocabulary, binary or text")->required();
  info_command->add_flag("--json", arguments->json, "as JSON on stdout");
  info_command->callback([arguments, &exit_code] { exit_code = covis::app::info(*arguments); });
  CLI::App* convert_command = vocab->add_subcommand("convert", "Convert between the text format and Covis' own");
  convert_command->add_option("IN", arguments->in, "vocabulary, binary or text")->required();
  convert_command->add_option("OUT", arguments->out, "file to write: text when its name ends in .txt, else binary")
      ->required();
  convert_command->add_flag("--overwrite", arguments->overwrite, "replace OUT");
  convert_command->callback([arguments, &exit_code] { exit_code = covis::app::convert(*arguments); });
  vocab->footer("See docs/vocabulary.md. A vocabulary ships with Covis: vocabulary/default.covis-voc.");
}
