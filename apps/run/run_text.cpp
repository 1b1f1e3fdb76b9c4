// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_text.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "covis/core/message_text.h"
#include "covis/geometry/camera_check.h"

namespace covis::app {
namespace {

std::string fixed(double value, int digits, const char* unit) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f%s", digits, value, unit);
  return text;
}

std::string focal_text(const RunSummary& s) {
  return fixed(s.camera.fx, 1, " pixels instead of ") + fixed(s.given.fx, 1, "");
}

// "k1 0.0231, k2 -0.0104, where none was given"
std::string distortion_text(const RunSummary& s) {
  return fixed(s.camera.residual.k1, 4, ", k2 ") + fixed(s.camera.residual.k2, 4, ", where none was given");
}

// "0.0205 seconds from the first row to the last"
std::string shutter_text(const RunSummary& s) {
  return fixed(s.camera.row_time * s.image_height, 4, " seconds from the first row to the last");
}

// "526.2 pixels ± 0.8 %, k1 -0.022 ± 0.003, k2 0.000 ± 0.007"
std::string estimate_text(const RunSummary& s) {
  const auto& [file, k1, k2, sigma] = *s.estimate;
  return fixed(s.given.fx, 1, " pixels ± ") + fixed(100 * sigma.focal, 1, " %, k1 ") + fixed(k1, 3, " ± ") +
         fixed(sigma.k1, 3, ", k2 ") + fixed(k2, 3, " ± ") + fixed(sigma.k2, 3, "");
}

// "12 frames dropped for newer ones; the camera went away 2 times"; empty where there is nothing to tell.
std::string live_text(const FrameCounts& frames) {
  std::string text;
  if (frames.dropped > 0) text = std::to_string(frames.dropped) + " frames dropped for newer ones";
  if (frames.camera_gone > 0) {
    text += (text.empty() ? "" : "; ") + std::string("the camera went away ") + std::to_string(frames.camera_gone) +
            (frames.camera_gone == 1 ? " time" : " times");
  }
  return text;
}

}  // namespace

std::string why_nothing_is_tracked(const RunSummary& s, const Camera& camera) {
  std::string why;
  for (const std::string& doubt : doubts_about(camera)) why += (why.empty() ? "" : "; ") + doubt;
  if (!why.empty()) return why;
  std::map<std::string, int64_t> frames;
  int64_t all = 0;
  for (const Loss& loss : s.not_tracked) {
    frames[loss.reason] += loss.last - loss.first + 1;
    all += loss.last - loss.first + 1;
  }
  if (frames.empty()) return "there was none";
  const auto most =
      std::max_element(frames.begin(), frames.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most->first + " (" + std::to_string(most->second) + " of " + std::to_string(all) + " frames)";
}

std::string summary_text(const RunSummary& s, const std::filesystem::path& out) {
  std::string text = std::to_string(s.frames.tracked) + " of " + std::to_string(s.frames.all) + " frames tracked, " +
                     std::to_string(s.map.key_frames) + " key frames, " + std::to_string(s.map.points) + " points\n";
  if (const std::string live = live_text(s.frames); !live.empty()) text += live + "\n";
  if (!s.failure.empty()) text += "ended early: " + shown(s.failure) + "\n";
  if (s.map.submaps.size() > 1) {
    text += std::to_string(s.map.submaps.size()) + " maps that could not be joined; trajectory.txt has the " +
            std::to_string(s.map.submaps.front().frames) + " frames of the first\n";
  }
  if (s.map.key_frames_thinned > 0) {
    text += std::to_string(s.map.key_frames_thinned) +
            " key frames were given up to keep the map within its bound of memory\n";
  }
  for (const SensorWarning& warning : s.warnings) text += "warning: " + describe(warning, s.sensor) + "\n";
  if (s.estimate) {
    text += "the camera is an estimate from the recording: focal length " + estimate_text(s) + " (" +
            s.estimate->file.string() + ")\n";
  }
  if (refined(s)) text += "focal length refined: " + focal_text(s) + "\n";
  if (s.camera.residual.any()) text += "distortion found: k1 " + distortion_text(s) + "\n";
  if (registration_found(s))
    text += "depth images are not registered to the images: " + description(s.camera.registration) + "\n";
  if (shutter_found(s)) text += "rolling shutter found: " + shutter_text(s) + " (readout)\n";
  text += "tracking " + fixed(s.times.tracking.median, 2, " ms a frame (median), ") +
          fixed(s.times.tracking.p95, 2, " ms (95 %); ") + fixed(s.costs.frames_per_second, 1, " frames/s in all; ") +
          "peak memory " + fixed(s.costs.peak_rss_mb, 0, " MB\n");
  if (s.accuracy) {
    text += "error (ATE RMSE): " + fixed(s.accuracy->ate, 4, " m after ") + name_of_alignment(s.accuracy->alignment) +
            " alignment, over " + fixed(s.accuracy->path_length, 1, " m\n");
  }
  return text + "written to " + out.string() + "\n";
}

std::vector<std::pair<std::string, std::string>> summary_rows(const RunSummary& s) {
  std::vector<std::pair<std::string, std::string>> rows{
      {"recording", s.source},
      {"frames tracked", std::to_string(s.frames.tracked) + " of " + std::to_string(s.frames.all)},
      {"key frames", std::to_string(s.map.key_frames)},
      {"map points", std::to_string(s.map.points)},
      {"tracking, median (95 %)",
       fixed(s.times.tracking.median, 2, " ms") + " (" + fixed(s.times.tracking.p95, 2, " ms)")},
      {"frames per second", fixed(s.costs.frames_per_second, 1, "")},
      {"peak memory", fixed(s.costs.peak_rss_mb, 0, " MB")}};
  if (const std::string live = live_text(s.frames); !live.empty()) rows.emplace_back("live camera", live);
  if (!s.failure.empty()) rows.emplace_back("ended early", s.failure);
  if (s.map.key_frames_thinned > 0) rows.emplace_back("key frames given up", std::to_string(s.map.key_frames_thinned));
  if (s.map.submaps.size() > 1) rows.emplace_back("maps, not joined", std::to_string(s.map.submaps.size()));
  for (const SensorWarning& w : s.warnings)
    rows.emplace_back("warning, frame " + std::to_string(w.frame), describe(w, s.sensor));
  if (s.estimate) rows.emplace_back("focal length, estimated from the recording", estimate_text(s));
  if (refined(s)) rows.emplace_back("focal length, refined", focal_text(s));
  if (s.camera.residual.any()) rows.emplace_back("distortion found", "k1 " + distortion_text(s));
  if (registration_found(s))
    rows.emplace_back("depth images, not registered to the images", description(s.camera.registration));
  if (shutter_found(s)) rows.emplace_back("rolling shutter found", shutter_text(s));
  if (s.accuracy) {
    rows.emplace_back(std::string("error (ATE RMSE, ") + name_of_alignment(s.accuracy->alignment) + ")",
                      fixed(s.accuracy->ate, 4, " m"));
    rows.emplace_back("error of the online poses", fixed(s.accuracy->ate_online, 4, " m"));
    rows.emplace_back("length of the path", fixed(s.accuracy->path_length, 2, " m"));
  }
  return rows;
}

}  // namespace covis::app
