// SPDX-License-Identifier: Apache-2.0
// covis check: describes a recording and reports its defects.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "check_picture.h"
#include "check_sensor.h"
#include "commands.h"
#include "common.h"
#include "covis/core/atomic_file.h"
#include "covis/core/log.h"
#include "covis/core/message_text.h"
#include "covis/core/quantile.h"
#include "covis/geometry/camera_check.h"
#include "covis/io/output_check.h"
#include "covis/io/sequence.h"
#include "import_camera.h"

namespace covis::app {
namespace {

struct CheckArguments {
  std::string path, out, import_camera;
  Reading reading;
  bool json = false;
};

struct Problem {
  std::optional<int64_t> frame;  // nullopt: of the recording as a whole
  std::string text;
};

double mean_grey(const ImageU8& image) {
  int64_t sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) sum += image(x, y);
  }
  return static_cast<double>(sum) / image.width() / image.height();
}

double depth_share(const ImageF& depth) {
  int64_t valid = 0;
  for (int y = 0; y < depth.height(); ++y)
    valid += std::count_if(depth.row(y), depth.row(y) + depth.width(), [](float d) { return d > 0; });
  return static_cast<double>(valid) / depth.width() / depth.height();
}

// Reports defects of a frame that are visible without tracking it.
void look_at(const io::Frame& frame, std::vector<Problem>& problems) {
  const double grey = mean_grey(frame.image);
  if (grey < 8)
    problems.push_back(
        {frame.index, "the image is nearly black (mean grey level " + std::to_string(static_cast<int>(grey)) + ")"});
  if (grey > 247) problems.push_back({frame.index, "the image is nearly white"});
  if (!frame.depth.empty() && depth_share(frame.depth) < 0.02)
    problems.push_back({frame.index, "the depth image is nearly empty"});
}

// Reports gaps of more than two and a half times the median interval.
void look_for_gaps(const std::vector<Timestamp>& stamps, std::vector<Problem>& problems,
                   const std::vector<int64_t>& frames) {
  std::vector<double> gaps;  // seconds
  for (size_t i = 1; i < stamps.size(); ++i) gaps.push_back(to_seconds(stamps[i] - stamps[i - 1]));
  const double usual = quantile(gaps, 0.5);
  for (size_t i = 0; i < gaps.size(); ++i) {
    if (gaps[i] > 2.5 * usual)
      problems.push_back({frames[i + 1], "comes " + std::to_string(gaps[i]) + " s after the frame before it"});
  }
}

void print(const nlohmann::json& found) {
  std::cout << shown(found["recording"].get<std::string>()) << "\n";
  std::printf("frames read     %lld, %lld unreadable\n", found["frames_read"].get<long long>(),
              found["frames_unreadable"].get<long long>());
  std::printf("rate            %.2f Hz, %.2f s in all\n", found["rate_hz"].get<double>(),
              found["seconds"].get<double>());
  std::cout << "camera          " << found["camera"].dump() << "\n";
  std::cout << "truth           " << (found["truth"].is_null() ? "none" : shown(found["truth"].get<std::string>()))
            << "\n";
  if (found.contains("depth_m")) {
    const auto& depth = found["depth_m"];
    std::printf(
        "depth           %.2f m (median of the keypoints), a tenth nearer than %.2f m, a tenth farther than %.2f m\n",
        depth["median"].get<double>(), depth["tenth"].get<double>(), depth["nine_tenths"].get<double>());
  }
  for (const auto& note : found["notes"]) std::cout << "note            " << shown(note.get<std::string>()) << "\n";
  for (const auto& problem : found["problems"]) {
    const std::string place =
        problem.contains("frame") ? "frame " + std::to_string(problem["frame"].get<int64_t>()) : "recording";
    std::printf("%-15s %s\n", place.c_str(), shown(problem["problem"].get<std::string>()).c_str());
  }
  std::printf("%zu problem%s\n", found["problems"].size(), found["problems"].size() == 1 ? "" : "s");
}

// Results of reading all frames.
struct Findings {
  std::vector<Problem> problems;
  std::vector<Timestamp> stamps;  // stamps of the readable frames
  std::vector<int64_t> frames;    // indices of the readable frames
  int64_t unreadable = 0;
  std::optional<SensorSample::Depths> depths;
};

Findings read_all(io::Sequence& sequence, const Reading& reading, CheckPicture& picture) {
  constexpr double kFewMatches = 0.08;
  Findings f;
  for (const std::string& doubt : doubts_about(sequence.camera())) f.problems.push_back({std::nullopt, doubt});
  for (const std::string& loss : sequence.losses()) f.problems.push_back({std::nullopt, loss});
  int64_t expected = reading.first;
  const int64_t size = sequence.size() > 0 ? sequence.size() : 300;
  SensorSample sensor(sequence.camera(), sequence.sensor(), sequence.size());
  const int64_t step = std::max<int64_t>(1, size / CheckPicture::kFrames);
  io::Frame frame;
  while (true) {
    auto next = sequence.next(std::move(frame));
    frame = {};
    if (!next) {
      ++f.unreadable;
      f.problems.push_back({expected, next.error().message});
      expected += reading.stride;
      continue;
    }
    if (!*next) break;
    frame = std::move(**next);
    expected = frame.index + reading.stride;
    f.stamps.push_back(frame.stamp);
    f.frames.push_back(frame.index);
    look_at(frame, f.problems);
    sensor.add(frame);
    if ((frame.index - reading.first) / reading.stride % step != 0) continue;
    const std::optional<double> matched = picture.add(frame);
    if (matched && *matched < kFewMatches) {
      f.problems.push_back({frame.index, "only " + std::to_string(static_cast<int>(100 * *matched)) +
                                             " % of the left keypoints have a match on the same row of the right "
                                             "image; is the pair rectified, and the left image the left one?"});
    }
  }
  look_for_gaps(f.stamps, f.problems, f.frames);
  if (const auto doubt = io::doubt_about_rate(sequence, reading.stride)) f.problems.push_back({std::nullopt, *doubt});
  for (const SensorWarning& w : sensor.warnings()) f.problems.push_back({w.frame, describe(w, sequence.sensor())});
  f.depths = sensor.depths();
  return f;
}

nlohmann::json to_json(const io::Sequence& sequence, const Findings& f) {
  const std::vector<std::string> losses = sequence.losses();  // they are among the problems
  std::vector<std::string> notes = sequence.notes();
  std::erase_if(notes,
                [&](const std::string& note) { return std::find(losses.begin(), losses.end(), note) != losses.end(); });
  nlohmann::json found{{"recording", sequence.description()},
                       {"kind", name_of(kKinds, sequence.kind())},
                       {"sensor", name(sequence.sensor())},
                       {"frames", sequence.size()},
                       {"frames_read", f.stamps.size()},
                       {"frames_unreadable", f.unreadable},
                       {"rate_hz", sequence.frame_rate()},
                       {"seconds", f.stamps.empty() ? 0 : to_seconds(f.stamps.back() - f.stamps.front())},
                       {"camera", camera_json(sequence.camera())},
                       {"truth", nullptr},
                       {"notes", notes}};
  if (const auto truth = sequence.truth()) found["truth"] = truth->file.string();
  if (f.depths)
    found["depth_m"] = {
        {"tenth", f.depths->tenth}, {"median", f.depths->median}, {"nine_tenths", f.depths->nine_tenths}};
  found["problems"] = nlohmann::json::array();
  for (const Problem& problem : f.problems) {
    nlohmann::json& entry = found["problems"].emplace_back(nlohmann::json{{"problem", problem.text}});
    if (problem.frame) entry["frame"] = *problem.frame;
  }
  return found;
}

int run(const CheckArguments& a) {
  if (!a.import_camera.empty()) return import_camera(a.import_camera, a.out.empty() ? "camera.yaml" : a.out);
  const std::string out = a.out.empty() ? "check.png" : a.out;
  const auto fits = io::check_output(out, io::OutputKind::picture, {a.path, a.reading.camera});
  if (!fits) return fail_with(fits.error());
  if (!a.out.empty()) {
    if (const auto writable = check_writable(out); !writable) return fail_with(writable.error());
  }
  const auto opened = io::open_sequence(a.path, a.reading.options());
  if (!opened) {
    log(LogLevel::error, opened.error().message);
    return 1;
  }
  CheckPicture picture((*opened)->camera(), (*opened)->sensor());
  const Findings f = read_all(**opened, a.reading, picture);
  nlohmann::json found = to_json(**opened, f);
  Result<void> written;
  if (!f.stamps.empty()) written = picture.write(out);
  if (written && !f.stamps.empty()) found["picture"] = out;
  if (a.json) {
    print_json(found);
  } else {
    print(found);
    if (found.contains("picture")) std::cout << picture.caption() << ": " << out << "\n";
  }
  if (!written) log(LogLevel::error, written.error().message);
  return f.problems.empty() && written && !f.stamps.empty() ? 0 : 1;
}

}  // namespace
}  // namespace covis::app

void add_check_command(CLI::App& app, int& exit_code) {
  using namespace covis::app;
  auto a = std::make_shared<CheckArguments>();
  CLI::App* command =
      app.add_subcommand("check", "Describe a recording and report what is wrong with it, with a picture");
  command->add_option("PATH", a->path, kRecordingPath);
  add_reading_options(*command, a->reading);
  command->add_flag("--json", a->json, "JSON on stdout");
  CLI::Option* import = command->add_option(
      "--import-camera", a->import_camera,
      "instead of checking a recording, make a camera file of a camera of Kalibr, COLMAP, Kimera, EuRoC, "
      "ROS, OpenCV or Open3D (docs/input.md)");
  for (CLI::Option* of_recordings : command->get_options()) {
    if (of_recordings != import && of_recordings != command->get_help_ptr()) import->excludes(of_recordings);
  }
  command->add_option("--out", a->out,
                      "the picture: stereo rows, depth overlay, or keypoints (default: check.png); with "
                      "--import-camera the camera file (default: camera.yaml); only such a picture or file of Covis "
                      "is replaced");
  command->footer(
      "Examples:\n  covis check rgbd_dataset_freiburg1_desk\n  covis check kitti/sequences/06 --out rows.png\n  covis "
      "check --import-camera camchain.yaml --out camera.yaml\nExit code 1 when there is a problem.");
  command->callback([a, &exit_code] {
    if (a->path.empty() && a->import_camera.empty()) throw CLI::RequiredError("PATH");
    exit_code = run(*a);
  });
}
