// SPDX-License-Identifier: Apache-2.0
// covis synth: renders a recording of a synthetic world, with exact ground truth.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "commands.h"
#include "common.h"
#include "covis/core/time.h"
#include "synth/sequence_writer.h"
#include "synth/synth.h"

namespace covis::app {
namespace {

struct SynthArguments {
  SynthOptions options;
  std::map<std::string, std::string> settings;  // field name to text, for the given flags
  std::string out;
  bool overwrite = false, quiet = false, json = false;
};

// "synth.depth_noise" is set by --depth-noise.
std::string flag_of(const std::string& field) {
  std::string flag = "--" + field.substr(field.find('.') + 1);
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

// A flag for something that the sensor does not have would do nothing.
Result<void> check_sensor_has(const SynthArguments& a) {
  const std::map<std::string, std::vector<std::string>> lacks{
      {"mono",
       {"synth.baseline", "synth.depth_noise", "synth.right_gain", "synth.right_offset", "synth.right_yaw",
        "synth.right_pitch", "synth.right_roll"}},
      {"stereo", {"synth.depth_noise"}},
      {"rgbd", {"synth.right_gain", "synth.right_offset", "synth.right_yaw", "synth.right_pitch", "synth.right_roll"}}};
  const auto sensor = lacks.find(a.options.sensor);
  if (sensor == lacks.end()) return {};
  for (const std::string& name : sensor->second) {
    if (const auto given = a.settings.find(name); given != a.settings.end() && !given->second.empty())
      return fail(flag_of(name) + ": it does nothing with --sensor " + a.options.sensor);
  }
  return {};
}

int synth(SynthArguments arguments) {
  for (const auto& [name, text] : arguments.settings) {
    if (text.empty()) continue;
    if (auto ok = set_field(fields(arguments.options), name, text); !ok) return fail_with(ok.error());
  }
  if (const auto has = check_sensor_has(arguments); !has) return fail_with(has.error());
  auto world = Synth::create(arguments.options);
  if (!world) return fail_with(world.error());
  end_well_on_signals();

  const bool shown = !arguments.quiet && isatty(STDERR_FILENO);
  const int frames = world->frames();
  const Stopwatch all;
  Stopwatch since;
  const auto progress = [&](int done) {
    if (shown && (since.ms() >= 100 || done == frames)) {
      since.restart();
      const double rate = done / std::max(all.ms() / 1000, 1e-3);
      std::fprintf(stderr, "\r\033[Kframe %d/%d  %.1f fps  %.0f s left", done, frames, rate,
                   (frames - done) / std::max(rate, 1e-3));
      std::fflush(stderr);
    }
    return interrupted == 0;
  };
  const Existing existing = arguments.overwrite ? Existing::replace : Existing::refuse;
  const auto report = write_sequence(*world, arguments.out, existing, progress);
  if (shown) std::fputs("\n", stderr);
  if (!report) {
    fail_with(report.error());
    return interrupted == 0 ? 1 : 128 + interrupted;
  }

  const SynthOptions& made = world->options();
  const double seconds = all.ms() / 1000;
  if (arguments.json) {
    const nlohmann::json summary{{"world", made.world},
                                 {"sensor", made.sensor},
                                 {"seed", made.seed},
                                 {"frames", report->frames},
                                 {"width", made.width},
                                 {"height", made.height},
                                 {"fps", made.fps},
                                 {"path_m", report->path_metres},
                                 {"image_bytes", report->bytes},
                                 {"frames_per_second", report->frames / std::max(seconds, 1e-3)},
                                 {"folder", arguments.out}};
    print_json(summary);
  } else if (!arguments.quiet) {
    std::printf("%s, %s, seed %d: %d frames of %dx%d at %g Hz, %.1f m of path, %.0f MB in %s (%.1f frames/s)\n",
                made.world.c_str(), made.sensor.c_str(), made.seed, report->frames, made.width, made.height, made.fps,
                report->path_metres, static_cast<double>(report->bytes) / 1e6, arguments.out.c_str(),
                report->frames / std::max(seconds, 1e-3));
  }
  return 0;
}

}  // namespace
}  // namespace covis::app

void add_synth_command(CLI::App& app, int& exit_code) {
  using namespace covis;
  using namespace covis::app;
  auto arguments = std::make_shared<SynthArguments>();
  CLI::App* command = app.add_subcommand("synth", "Render a recording of a synthetic world, with exact truth");
  for (const Field& field : fields(arguments->options)) {
    std::string& text = arguments->settings[field.name];
    if (field.name == "synth.world") {
      command->add_option("WORLD", text, field.doc)->required()->type_name("NAME");
    } else {
      const bool word = std::holds_alternative<std::string*>(field.value);
      command->add_option(flag_of(field.name), text, field.doc)
          ->default_str(field_text(field))
          ->type_name(word ? "NAME" : "NUMBER");
    }
  }
  command->add_option("--out", arguments->out, "folder for the recording")->required();
  command->add_flag("--overwrite", arguments->overwrite, "replace the recording that is in the folder");
  command->add_flag("--quiet", arguments->quiet, "no progress, no summary");
  command->add_flag("--json", arguments->json, "the summary as JSON on stdout");
  command->footer(
      "Makes a TUM RGB-D folder (rgbd), a KITTI odometry folder (stereo) or an image folder (mono); see "
      "docs/synth.md.\n"
      "Examples:\n"
      "  covis synth room --out room\n"
      "  covis synth street --sensor stereo --width 1241 --height 376 --seed 7 --out street\n"
      "  covis synth corridor --sensor mono --frames 300 --out corridor\n"
      "  covis synth desk --noise 3 --depth-noise 1 --exposure 0.2 --blur 8 --distortion 1 --out desk");
  command->callback([arguments, &exit_code] { exit_code = covis::app::synth(*arguments); });
}
