// SPDX-License-Identifier: Apache-2.0
#include "apps/run/camera_of_recording.h"

#include <cstdio>
#include <utility>

#include "covis/core/atomic_file.h"
#include "covis/core/log.h"
#include "covis/io/camera_file.h"
#include "covis/io/output_check.h"
#include "covis/slam/camera_search.h"

namespace covis::app {
namespace {

// Unreadable frames are passed over.
Result<void> play(const std::string& path, const io::SequenceOptions& reading, const FrameVisitor& visit) {
  const auto sequence = io::open_sequence(path, reading);
  if (!sequence) return tl::unexpected(sequence.error());
  io::Frame frame;
  for (;;) {
    auto next = (*sequence)->next(std::move(frame));
    frame = {};
    if (!next) continue;
    if (!*next) return {};
    frame = std::move(**next);
    if (!visit(frame.image.view(), frame.stamp)) return {};
  }
}

std::string file_text(const FoundCamera& found) {
  char head[400];
  std::snprintf(head, sizeof head,
                ", by %zu key frames: the focal length is uncertain by %.1f %% (one\n"
                "# standard deviation), k1 by %.3f, k2 by %.3f, the principal point by %.1f and %.1f pixels.\n",
                found.key_frames, 100 * found.sigma.focal, found.sigma.k1, found.sigma.k2, found.sigma.cx,
                found.sigma.cy);
  io::CameraFile file;
  file.camera = found.camera;
  return std::string(io::kCameraEstimate).append(head).append(io::camera_text(file));
}

}  // namespace

Result<CameraEstimate> find_camera_of(const std::string& path, const io::SequenceOptions& reading,
                                      const SystemOptions& options, const std::filesystem::path& out, bool quiet,
                                      const std::atomic<int>& interrupt) {
  const auto opened = io::open_sequence(path, reading);
  if (!opened) return tl::unexpected(opened.error());
  const std::filesystem::path file = out / "camera.yaml";
  if (const auto fits = io::check_output(file, io::OutputKind::camera_estimate, {path}); !fits)
    return fail(fits.error().message + ", or, if it is this recording's camera, give it with --camera");
  const int width = (*opened)->camera().width, height = (*opened)->camera().height;
  const auto tell = [&](const std::string& message) {
    if (!quiet) log(LogLevel::info, message);
  };
  tell(path + ": no camera is given; finding it from the recording");
  const RecordingPlayer player = [&](const FrameVisitor& visit) { return play(path, reading, visit); };
  const auto found = find_camera(width, height, player, options, tell, &interrupt);
  if (!found) {
    return fail(path + ": no camera is given, and the recording does not tell it: " + found.error().message +
                ". Give one with --camera FILE; covis calibrate makes one");
  }
  CameraEstimate estimate{file, found->camera.coefficients[0], found->camera.coefficients[1], found->sigma};
  if (const auto written = write_atomically(estimate.file, file_text(*found)); !written)
    return tl::unexpected(written.error());
  return estimate;
}

}  // namespace covis::app
