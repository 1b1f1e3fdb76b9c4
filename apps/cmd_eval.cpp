// SPDX-License-Identifier: Apache-2.0
// covis eval: the deviation of a trajectory from the ground truth.
#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <system_error>

#include "commands.h"
#include "common.h"
#include "covis/core/atomic_file.h"
#include "covis/eval/evaluation.h"
#include "covis/eval/report.h"
#include "covis/io/output_check.h"

namespace covis::app {
namespace {

struct EvalArguments {
  std::string trajectory, truth, align = "se3", format = "auto", truth_format = "auto", stamps, truth_stamps,
                                 delta_unit = "frames", plot;
  double max_difference = 0.02, delta = 1;
  bool json = false;
};

const std::map<std::string, AlignMode> kAligns{{"se3", AlignMode::se3},
                                               {"sim3", AlignMode::sim3},
                                               {"none", AlignMode::none},
                                               {"first", AlignMode::first},
                                               {"first-sim3", AlignMode::first_sim3}};
const std::map<std::string, DeltaUnit> kUnits{
    {"frames", DeltaUnit::frames}, {"s", DeltaUnit::seconds}, {"m", DeltaUnit::metres}};
const std::map<std::string, io::TrajectoryFormat> kReadFormats{
    {"auto", io::TrajectoryFormat::automatic},      {"tum", io::TrajectoryFormat::tum},
    {"kitti", io::TrajectoryFormat::kitti},         {"euroc", io::TrajectoryFormat::euroc},
    {"tartanair", io::TrajectoryFormat::tartanair}, {"icl-nuim", io::TrajectoryFormat::icl_nuim}};

// The name of the file with the stamps of a trajectory's rows, which covis writes beside one of KITTI.
std::string times_of(const std::string& trajectory) {
  const std::filesystem::path times = io::times_file(trajectory);
  std::error_code none;
  return std::filesystem::exists(times, none) ? times.string() : "times.txt";
}

// Rows of KITTI without stamps fit nothing but other rows without stamps; those of TartanAir are at 10 Hz where the
// other file has stamps, as covis run has them. Returns whether any stamps are known.
Result<bool> check_stamps(const EvalArguments& a) {
  bool stamped[2], timeless[2];
  const std::string files[] = {a.trajectory, a.truth}, stamps[] = {a.stamps, a.truth_stamps},
                    formats[] = {a.format, a.truth_format}, options[] = {"--stamps", "--truth-stamps"};
  for (size_t k = 0; k < 2; ++k) {
    const auto format = io::trajectory_format(files[k], kReadFormats.at(formats[k]));
    if (!format) return tl::unexpected(format.error());
    stamped[k] = io::has_stamps(*format);
    if (stamped[k] && !stamps[k].empty())
      return fail(options[k] + " " + stamps[k] + ": " + files[k] + " has stamps of its own");
    stamped[k] |= !stamps[k].empty();
    timeless[k] = !stamped[k] && *format == io::TrajectoryFormat::kitti;
  }
  if (stamped[0] == stamped[1]) return stamped[0];
  const size_t without = stamped[0] ? 1 : 0;
  if (!timeless[without]) return true;
  return fail(files[without] + ": it has no stamps, and " + files[1 - without] + " has; give those of its rows with " +
              options[without] + " " + times_of(files[without]));
}

// Rows without stamps belong together by their number, which holds only where no row is missing.
Result<void> pair_rows(const EvalArguments& a, const Trajectory& estimate, Trajectory& truth) {
  if (estimate.size() != truth.size())
    return fail(a.trajectory + " has " + std::to_string(estimate.size()) + " rows and " + a.truth + " has " +
                std::to_string(truth.size()) + ", none with a stamp, so that it is not known which belong together; " +
                "give the stamps of both with --stamps " + times_of(a.trajectory) + " and --truth-stamps " +
                times_of(a.truth));
  for (size_t k = 0; k < truth.size(); ++k) truth[k].stamp = estimate[k].stamp;
  return {};
}

int run(const EvalArguments& a) {
  if (!a.plot.empty()) {
    const bool page = std::filesystem::path(a.plot).extension() == ".html";
    const auto kind = page ? io::OutputKind::page : io::OutputKind::picture;
    const auto fits = io::check_output(a.plot, kind, {a.trajectory, a.truth, a.stamps, a.truth_stamps});
    if (!fits) return fail_with(fits.error());
    if (const auto writable = check_writable(a.plot); !writable) return fail_with(writable.error());
  }
  if (a.delta_unit == "frames" && a.delta != std::floor(a.delta))
    return fail_with("--delta " + std::to_string(a.delta) + ": a number of frames is whole");
  const auto stamped = check_stamps(a);
  if (!stamped) return fail_with(stamped.error());
  const auto estimate = io::read_trajectory(a.trajectory, kReadFormats.at(a.format), a.stamps);
  if (!estimate) return fail_with(estimate.error());
  auto truth = io::read_trajectory(a.truth, kReadFormats.at(a.truth_format), a.truth_stamps);
  if (!truth) return fail_with(truth.error());
  if (!*stamped) {
    if (const auto paired = pair_rows(a, *estimate, *truth); !paired) return fail_with(paired.error());
  }
  EvaluationOptions options;
  options.align = kAligns.at(a.align);
  options.max_difference = a.max_difference;
  options.delta = a.delta;
  options.delta_unit = kUnits.at(a.delta_unit);
  const auto evaluation = evaluate(*estimate, *truth, options);
  if (!evaluation) return fail_with(evaluation.error());
  if (!a.plot.empty()) {
    const std::string title = a.trajectory + " against " + a.truth;
    if (const auto written = write_picture(a.plot, title, *evaluation); !written) return fail_with(written.error());
  }
  if (a.json) {
    print_json(to_json(*evaluation));
  } else {
    std::cout << to_text(*evaluation);
  }
  return 0;
}

}  // namespace
}  // namespace covis::app

void add_eval_command(CLI::App& app, int& exit_code) {
  using namespace covis::app;
  auto a = std::make_shared<EvalArguments>();
  CLI::App* command =
      app.add_subcommand("eval", "Compare a trajectory with the truth: ATE, RPE, KITTI errors, coverage");
  command->add_option("TRAJECTORY", a->trajectory, "the estimate: TUM, KITTI or EuRoC file")->required();
  command
      ->add_option(
          "TRUTH", a->truth,
          "the truth: TUM, KITTI, EuRoC, TartanAir or ICL-NUIM file (of the camera; EuRoC's own truth is of the body)")
      ->required();
  command
      ->add_option("--align", a->align,
                   "se3, sim3 (with scale: monocular), none, or first, first-sim3 (by the first pose: shows the drift)")
      ->capture_default_str()
      ->check(CLI::IsMember(keys(kAligns)));
  command->add_flag("--json", a->json, "JSON on stdout");
  command->add_option(
      "--plot", a->plot,
      "picture of the path from above beside the truth and of the error over time: a .png or .html file");
  command->add_option("--max-difference", a->max_difference, "seconds between a pose and its truth")
      ->capture_default_str()
      ->check(positive_number());
  command->add_option("--delta", a->delta, "step of the relative pose error")
      ->capture_default_str()
      ->check(positive_number());
  command->add_option("--delta-unit", a->delta_unit, "frames, s or m")
      ->capture_default_str()
      ->check(CLI::IsMember(keys(kUnits)));
  command->add_option("--format", a->format, "of the trajectory")
      ->capture_default_str()
      ->check(CLI::IsMember(keys(kReadFormats)));
  command->add_option("--truth-format", a->truth_format, "of the truth")
      ->capture_default_str()
      ->check(CLI::IsMember(keys(kReadFormats)));
  command->add_option("--stamps", a->stamps, "times.txt of a KITTI or TartanAir trajectory, a stamp for each row");
  command->add_option("--truth-stamps", a->truth_stamps,
                      "times.txt of a KITTI or TartanAir truth, a stamp for each row");
  command->footer(
      "Examples:\n"
      "  covis eval out/trajectory.txt groundtruth.txt --plot errors.png\n"
      "  covis eval out/trajectory_online.txt groundtruth.txt --align sim3 --json\n"
      "  covis eval out/trajectory.txt poses.txt --truth-stamps times.txt\n"
      "  covis eval out/trajectory.txt P001/pose_left.txt            # TartanAir");
  command->callback([a, &exit_code] { exit_code = run(*a); });
}
