// SPDX-License-Identifier: Apache-2.0
// Says what happens while a folder of images is tracked: key frames, loops, losses, and the library's own messages.
//   events FOLDER FOCAL_LENGTH
#include <string_view>

#include "images.h"

int main(int argc, char** argv) {
  if (argc != 3) return fail("usage: events FOLDER FOCAL_LENGTH");
  const std::vector<std::string> files = images_of(argv[1]);
  if (files.empty()) return fail(std::string(argv[1]) + ": no images in it");
  covis::set_log_sink([](covis::LogLevel level, std::string_view message) {
    if (level >= covis::LogLevel::info) std::printf("covis: %.*s\n", static_cast<int>(message.size()), message.data());
  });

  const auto slam = covis::Slam::create({
      .sensor = covis::SensorType::monocular,
      .camera = camera_of(read_grey(files[0]), std::atof(argv[2])),
      .timing = covis::Timing::deterministic,
  });
  if (!slam) return fail(slam.error());
  (*slam)->on_event([&](const covis::Event& event) {
    std::printf("%7.3f s: %s, submap %d", event.stamp * 1e-9, covis::name(event.kind), event.submap);
    if (event.key_frame) std::printf(", key frame %llu", static_cast<unsigned long long>(*event.key_frame));
    if (event.kind == covis::Event::Kind::lost) std::printf(": %s", covis::describe(event.reason));
    std::printf(" (the map has %zu points)\n", (*slam)->snapshot()->points.size());
  });
  for (size_t i = 0; i < files.size(); ++i) {
    const cv::Mat image = read_grey(files[i]);
    const auto result = (*slam)->track({.stamp = static_cast<int64_t>(i) * 33'333'333, .image = view(image)});
    if (!result) return fail(files[i] + ": " + result.error());
  }
  (*slam)->finish();
}
