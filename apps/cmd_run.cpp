// SPDX-License-Identifier: Apache-2.0
// covis run: reads a recording or a camera, and writes a trajectory and a map.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "apps/run/activity.h"
#include "apps/run/camera_of_recording.h"
#include "apps/run/key_frame_pictures.h"
#include "apps/run/map_saver.h"
#include "apps/run/memory_bound.h"
#include "apps/run/resources.h"
#include "apps/run/run_json.h"
#include "apps/run/run_loop.h"
#include "apps/run/run_outputs.h"
#include "apps/run/run_text.h"
#include "apps/run/run_view.h"
#include "commands.h"
#include "common.h"
#include "covis/core/atomic_file.h"
#include "covis/core/fields.h"
#include "covis/core/log.h"
#include "covis/core/simd_targets.h"
#include "covis/geometry/camera_check.h"
#include "covis/io/codecs.h"
#include "covis/io/config.h"
#include "covis/io/files.h"
#include "covis/io/plugin.h"
#include "covis/io/sequence.h"
#include "covis/slam/system.h"
#include "covis/storage/compatibility.h"
#include "places.h"
#include "viewing.h"

namespace covis::app {
namespace {

struct RunArguments {
  std::string path;
  Reading reading;
  std::string out = "out";
  std::string simd = "best";
  std::string config, format = "tum";
  std::string vocabulary, map, save_map, save_every = "120s";
  std::vector<std::string> settings;
  int features = 0, max_memory = 0;
  ViewOptions view;
  bool realtime = false, localize = false, quiet = false, json = false, dump_config = false;
  bool no_colours = false, keep_images = false;
};

const std::map<std::string, io::TrajectoryFormat> kWriteFormats{
    {"tum", io::TrajectoryFormat::tum}, {"kitti", io::TrajectoryFormat::kitti}, {"euroc", io::TrajectoryFormat::euroc}};

// Combines the settings from the file, --set and the other options.
Result<void> apply_settings(const RunArguments& arguments, const Fields& known, SystemOptions& options) {
  if (!arguments.config.empty()) {
    if (auto loaded = io::load_settings(arguments.config, known); !loaded) return loaded;
  }
  if (auto set = set_all(arguments.settings, known); !set) return set;
  if (auto set = set_features(arguments.features, arguments.settings, options.orb.features); !set) return set;
  if (options.trajectory_frames > 0)
    return fail("system.trajectory_frames: it is for programs; the results of covis run hold every frame");
  options.realtime = options.realtime || arguments.realtime;
  options.localize = options.localize || arguments.localize;
  return {};
}

Result<void> choose_instructions(const std::string& name) {
  if (use_simd_target(name)) return {};
  std::string names = "best";
  for (const std::string& target : simd_targets()) names += ", " + target;
  return fail("--simd " + name + ": there is no such instruction set here; there are " + names);
}

// The results must not take the place of what the run reads, nor of its map.
Result<void> open_results(const RunArguments& a, const io::Sequence& sequence) {
  const auto truth = sequence.truth();
  return open_output_folder(
      a.out, {a.path, a.reading.camera, a.config, a.vocabulary, a.map, a.save_map, truth ? truth->file : ""});
}

// Says what is played, and why its camera or its stamps can hardly be right.
void announce(const RunArguments& arguments, const io::Sequence& sequence) {
  if (!arguments.quiet) log(LogLevel::info, sequence.description());
  for (const std::string& doubt : doubts_about(sequence.camera())) log(LogLevel::warning, doubt);
  if (const auto doubt = io::doubt_about_rate(sequence, arguments.reading.stride)) log(LogLevel::warning, *doubt);
}

std::string title_of(const RunArguments& arguments) {
  const std::filesystem::path path = io::normal_path(arguments.path);
  return (path.has_filename() ? path.filename() : path.parent_path().filename()).string();
}

// Messages begin with it; those of a camera name it themselves.
std::string named(const RunArguments& arguments, io::SequenceKind kind) {
  return kind == io::SequenceKind::camera ? "" : arguments.path + ": ";
}

OutputOptions output_options(const RunArguments& arguments, const storage::MapHeader& header,
                             const std::optional<Trajectory>& truth) {
  return {.directory = arguments.out,
          .format = kWriteFormats.at(arguments.format),
          .title = title_of(arguments),
          .truth = truth ? &*truth : nullptr,
          .unit = io::unit_of(header.sensor)};
}

// Saves the map if that is requested, then writes the summary and the run's files. Each is written whatever becomes of
// the others; the first that can't be is the error. `first_own`: the serial of the first key frame of this run.
// `images`: where to keep key frames' images.
Result<RunSummary> save(const RunArguments& arguments, const RunRecord& record, const System& system,
                        io::Sequence& sequence, const storage::MapHeader& header, uint32_t first_own,
                        const std::optional<exchange::KeptImages>& images, std::optional<MapSaver>& saver) {
  enter_part("while the results are written");
  const double peak_mb = peak_rss_mb();  // the run, without what writing takes
  // A run that failed before it tracked a frame adds nothing to the map that it was given.
  const bool to_save =
      !arguments.save_map.empty() && (record.failure.empty() || !system.snapshot()->trajectory.empty());
  const Result<void> saved = io::without_exceptions(arguments.save_map, [&] {
    return to_save ? save_map(arguments.save_map, system.map_state(), header, saver) : Result<void>();
  });
  RunSummary summary;
  const Result<void> written = io::without_exceptions(arguments.out, [&] {
    const std::optional<Trajectory> truth = read_truth(sequence);
    const std::shared_ptr<const Snapshot> snapshot = system.snapshot();
    const OutputOptions output = output_options(arguments, header, truth);
    summary = summarise(record, *snapshot, output.truth, peak_mb);
    return write_outputs(record, *snapshot, summary, output);
  });
  Result<void> kept;
  if (images && saved && to_save && system.map_size().key_frames > 0) {
    kept = io::without_exceptions(
        images->folder(), [&] { return keep_images(sequence, system.map_state(), first_own, arguments.map, *images); });
  }
  for (const Result<void>* done : {&saved, &written, &std::as_const(kept)}) {
    if (!*done)
      return fail((record.failure.empty() ? "" : named(arguments, sequence.kind()) + record.failure + "; ") +
                  done->error().message);
  }
  return summary;
}

// Prints the summary; returns the exit code, and says why where it is not 0.
int conclude(const RunArguments& arguments, const RunSummary& summary, io::SequenceKind kind, const Camera& camera) {
  if (arguments.json) {
    print_json(to_json(summary));
  } else if (!arguments.quiet) {
    std::fputs(summary_text(summary, arguments.out).c_str(), stdout);
  }
  if (!summary.failure.empty()) {
    return fail_with(named(arguments, kind) + summary.failure + "; the results so far are written");
  }
  // Ctrl-C is the normal end of a camera; for a recording the exit code is the shell's code for the signal.
  if (summary.interrupted && kind != io::SequenceKind::camera) {
    log(LogLevel::warning, "interrupted; the results so far are written");
    return 128 + interrupted;
  }
  if (summary.frames.tracked > 0) return 0;
  return fail_with(arguments.path + ": no frame was tracked: " + why_nothing_is_tracked(summary, camera));
}

// Bounds the map so that the whole run stays within --max-memory.
Result<void> bound_memory(const RunArguments& arguments, const Camera& camera, SystemOptions& options) {
  if (arguments.max_memory == 0) return {};
  std::error_code none;
  const uint64_t vocabulary = arguments.vocabulary.empty() || arguments.vocabulary == "none"
                                  ? 0
                                  : std::filesystem::file_size(arguments.vocabulary, none);
  const auto map = map_megabytes(arguments.max_memory, camera, none ? 0 : vocabulary);
  if (!map) return tl::unexpected(map.error());
  if (options.mapper.max_map_mb == 0 || *map < options.mapper.max_map_mb) options.mapper.max_map_mb = *map;
  return {};
}

PlayOptions play_options(const RunArguments& arguments, const SystemOptions& options, io::SequenceKind kind,
                         RunObserver* observer, MapSaver* saver) {
  PlayOptions play;
  play.first = arguments.reading.first;
  play.stride = arguments.reading.stride;
  // A camera's frames arrive in real time anyway.
  if (arguments.realtime && kind != io::SequenceKind::camera) play.pacing = Pacing::recorded;
  if (options.localize) play.mode = RunMode::localization;
  play.show_progress = !arguments.quiet;
  play.colours = !arguments.no_colours && !options.localize;
  play.stop = &interrupted;
  play.observer = observer;
  play.saver = saver;
  return play;
}

// Checks before the run what is to be saved after it. Returns the interval of savings meanwhile. A folder that comes
// with the results is open_outputs()'s to check.
Result<SaveInterval> check_saving(const RunArguments& arguments, const SystemOptions& options, io::SequenceKind kind) {
  if (arguments.keep_images && arguments.save_map.empty())
    return fail("--keep-images: the images are kept beside a saved map, --save-map FILE");
  if (arguments.keep_images && kind == io::SequenceKind::camera)
    return fail("--keep-images: a camera's images can't be read again; record a video and run on that");
  auto interval = parse_save_interval(arguments.save_every);
  if (!interval) return interval;
  if (arguments.save_map.empty() || options.localize) *interval = {};  // localising changes no map
  if (arguments.save_map.empty() || comes_with_results(arguments.save_map, arguments.out)) return interval;
  if (auto fits = check_map_target(arguments.save_map, *interval); !fits) return tl::unexpected(fits.error());
  return interval;
}

nlohmann::json live_info(const RunRecord& record, const RunArguments& arguments, bool realtime) {
  nlohmann::json info = view_info(record, title_of(arguments), "live");
  info["realtime"] = realtime;
  return info;
}

Result<void> open_outputs(const RunArguments& arguments, const SaveInterval& interval, const io::Sequence& sequence) {
  const bool unchecked = !arguments.save_map.empty() && comes_with_results(arguments.save_map, arguments.out);
  if (auto opened = open_results(arguments, sequence); !opened) return opened;
  return unchecked ? check_map_target(arguments.save_map, interval) : Result<void>();
}

// The results have pictures. That none can be written is an error before anything is tracked.
auto open_recording(const std::string& path, const io::SequenceOptions& reading) {
  auto sequence = io::open_sequence(path, reading);
  if (const auto codecs = io::plugin<io::CodecPlugin>(); sequence && !codecs) sequence = tl::unexpected(codecs.error());
  return sequence;
}

int run(const RunArguments& arguments) {
  SystemOptions options;
  const Fields known = fields(options);
  if (const auto applied = apply_settings(arguments, known, options); !applied) return fail_with(applied.error());
  if (arguments.dump_config) return std::fputs(io::dump_settings(known).c_str(), stdout) < 0;
  if (const auto chosen = choose_instructions(arguments.simd); !chosen) return fail_with(chosen.error());
  if (arguments.path.empty())
    return fail_with("run: PATH is missing: a recording's folder, a bag, a video file or a camera's number");
  // From here on Ctrl-C ends the run like the end of the recording.
  end_well_on_signals();
  io::SequenceOptions reading = arguments.reading.options();
  reading.uncalibrated = arguments.map.empty();
  reading.stop = &interrupted;
  auto sequence = open_recording(arguments.path, reading);
  if (!sequence) return fail_with(sequence.error());
  options.sensor = (*sequence)->sensor();
  if (options.localize && arguments.map.empty())
    return fail_with("--localize: it needs a map to localise in, --map FILE");
  const auto vocabulary = open_vocabulary(arguments.vocabulary);
  if (!vocabulary) return fail_with(vocabulary.error());
  if (const auto bounded = bound_memory(arguments, (*sequence)->camera(), options); !bounded)
    return fail_with(bounded.error());
  RunRecord record;
  if (lacks_calibration(**sequence)) {
    if (const auto opened = open_results(arguments, **sequence); !opened) return fail_with(opened.error());
    const auto found = find_camera_of(arguments.path, reading, options, arguments.out, arguments.quiet, interrupted);
    if (interrupted != 0) {
      log(LogLevel::warning, "interrupted; nothing is written");
      return 128 + interrupted;
    }
    if (!found) return fail_with(found.error());
    record.estimate = *found;
    reading.camera_file = found->file;
    sequence = io::open_sequence(arguments.path, reading);
    if (!sequence) return fail_with(sequence.error());
  }
  storage::MapHeader header = storage::header_of((*sequence)->camera(), options.sensor, options.orb, vocabulary->get());
  const auto interval = check_saving(arguments, options, (*sequence)->kind());
  if (!interval) return fail_with(interval.error());
  std::optional<storage::SavedMap> map;
  if (!arguments.map.empty()) {
    const auto use = options.localize ? storage::MapUse::localization : storage::MapUse::continuation;
    auto opened = storage::load_compatible_map(arguments.map, header, use);
    if (!opened) return fail_with(opened.error());
    map = std::move(*opened);
    header = storage::header_after(header, map->header);
  }
  record.source = (*sequence)->description();
  record.sensor = options.sensor;
  record.given = (*sequence)->camera().pinhole;
  record.image_width = (*sequence)->camera().width;
  record.image_height = (*sequence)->camera().height;
  std::optional<System> system;  // must outlive the viewer, which reads its map
  std::unique_ptr<RunViewer> viewer;
  if (!arguments.view.port.empty()) {
    auto started = RunViewer::start(arguments.view, live_info(record, arguments, options.realtime));
    if (!started) return fail_with("--view: " + started.error().message);
    viewer = std::move(*started);
  }
  if (const auto opened = open_outputs(arguments, *interval, **sequence); !opened) return fail_with(opened.error());
  std::optional<exchange::KeptImages> images;
  if (arguments.keep_images) {
    auto opened = exchange::KeptImages::open_to_write(exchange::image_folder(arguments.save_map));
    if (!opened) return fail_with(opened.error());
    images = std::move(*opened);
  }

  announce(arguments, **sequence);
  const uint32_t first_own = map ? map->map.next_serial() : 0;
  system.emplace((*sequence)->camera(), options, *vocabulary);
  if (map) {
    if (const auto set = system->set_map(std::move(map->map), map->header.camera); !set)
      return fail_with(arguments.map + ": " + set.error().message);
  }
  record.given.row_time = system->camera().row_time;  // a setting or the map may have it too
  std::optional<MapSaver> saver;
  if (*interval != SaveInterval{}) saver.emplace(arguments.save_map, header, *interval);
  track_all(**sequence, *system,
            play_options(arguments, options, (*sequence)->kind(), viewer ? viewer->observer() : nullptr,
                         saver ? &*saver : nullptr),
            record);
  for (const std::string& note : record.notes) log(LogLevel::warning, note);
  if (const auto why = why_nothing_is_written(record, *system->snapshot(), arguments.out)) {
    fail_with(named(arguments, (*sequence)->kind()) + *why);
    const bool is_camera = (*sequence)->kind() == io::SequenceKind::camera;
    return record.failure.empty() && interrupted != 0 && !is_camera ? 128 + interrupted : 1;
  }

  const auto summary = save(arguments, record, *system, **sequence, header, first_own, images, saver);
  if (viewer)
    viewer->run_ended(view_state(record, *system->snapshot(), summary ? *summary : RunSummary(), title_of(arguments)));
  if (!summary) return fail_with(summary.error());
  const int code = conclude(arguments, *summary, (*sequence)->kind(), (*sequence)->camera());
  if (viewer && arguments.view.at_end == ViewOptions::AtEnd::keep_serving) {
    std::fflush(stdout);
    viewer->serve();
  }
  return code;
}

}  // namespace
}  // namespace covis::app

void add_run_command(CLI::App& app, int& exit_code) {
  using namespace covis::app;
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "Track a recording, a video or a camera, and make a map");
  command->add_option("PATH", arguments->path, kRecordingPath);
  add_reading_options(*command, arguments->reading);
  command->add_option("--out", arguments->out, "folder for the results")->capture_default_str();
  command->add_option("--map", arguments->map, "saved map to continue; the camera is located in it");
  command->add_flag("--localize", arguments->localize, "localise only: the map given by --map is not changed");
  CLI::Option* save_map =
      command->add_option("--save-map", arguments->save_map, "file to save the map to (docs/map-format.md)");
  command
      ->add_option("--save-every", arguments->save_every,
                   "save the map aside, to FILE.unfinished, after so many frames (500) or seconds (120s) each, so "
                   "that a kill loses no more; 0: never")
      ->capture_default_str()
      ->needs(save_map);
  command
      ->add_option("--max-memory", arguments->max_memory,
                   "MB that the run may take: the map loses key frames where that costs least (docs/places.md)")
      ->transform(whole_number_from(1, 1'000'000));
  command->add_flag("--keep-images", arguments->keep_images,
                    "keep the key frames' images in the folder FILE.images beside the saved map, for covis map export");
  command->add_flag("--no-colours", arguments->no_colours,
                    "do not read key frames again for their colours; the map's points stay grey");
  command->add_option("--vocabulary", arguments->vocabulary,
                      "vocabulary for recognising places; none: do not recognise any (default: the one that ships)");
  command->add_flag("--realtime", arguments->realtime,
                    "process frames at their own times; late ones are dropped and counted");
  command->add_option("--format", arguments->format, "trajectory format: tum, kitti or euroc")
      ->capture_default_str()
      ->check(CLI::IsMember(keys(kWriteFormats)));
  command->add_option("--features", arguments->features, "keypoints per image (short for --set orb.features=N)")
      ->transform(whole_number_from(50, 30000));
  command
      ->add_option("--simd", arguments->simd,
                   "instruction set of the image kernels: best, scalar or a name (an unknown one lists them); the "
                   "results are the same")
      ->capture_default_str();
  add_run_view_options(*command, arguments->view);
  command->add_option("--config", arguments->config, "settings YAML");
  command->add_option("--set", arguments->settings, "one setting, NAME=VALUE; may be repeated")
      ->allow_extra_args(false);
  command->add_flag("--dump-config", arguments->dump_config, "print all settings with their meaning, and end");
  command->add_flag("--quiet", arguments->quiet, "no progress, no summary");
  command->add_flag("--json", arguments->json, "the summary as JSON on stdout");
  command->footer(
      "Examples:\n"
      "  covis run rgbd_dataset_freiburg1_desk --out desk\n"
      "  covis run kitti/sequences/06 --sensor stereo --features 2000 --out kitti06\n"
      "  covis run video.mp4 --out video                  the camera is found from the video\n"
      "  covis run video.mp4 --camera phone.yaml --out video\n"
      "  covis run office.bag --topic /camera/color/image_raw --out office\n"
      "  covis run 0 --camera webcam.yaml --realtime --out live\n"
      "  covis run 0 --camera webcam.yaml --realtime --view --out live          watch it in a browser\n"
      "  (A live camera runs until Ctrl-C. Only its newest frame is tracked; frames in between are dropped and "
      "counted. "
      "One that is unplugged is opened again when it is back, and located in the map.)\n"
      "  covis run office1 --out o1 --save-map office.m\n"
      "  covis run office2 --out o2 --map office.m --save-map office.m      continue the map\n"
      "  covis run office3 --out o3 --map office.m --localize");
  command->callback([arguments, &exit_code] {
    if (arguments->max_memory > 0) return_memory_at_once();
    exit_code = run(*arguments);
  });
}
