// SPDX-License-Identifier: Apache-2.0
// Prints the pose of every frame of a recording in raw arrays, for tools/test_aarch64.
//   poses SENSOR FX FY CX CY BASELINE VOCABULARY WIDTH HEIGHT FRAMES
// FRAMES has of each frame its stamp (8 bytes, nanoseconds), the grey image, and the right image (stereo, as grey) or
// the depth (rgbd, float32, metres), as this machine and the one that wrote it lay them out.
#include <covis/covis.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

bool read(std::FILE* file, void* to, size_t bytes) { return std::fread(to, 1, bytes, file) == bytes; }

int fail(const std::string& message) { return std::fprintf(stderr, "%s\n", message.c_str()), 1; }

}  // namespace

int main(int argc, char** argv) {
  if (argc != 11) return fail("usage: poses SENSOR FX FY CX CY BASELINE VOCABULARY WIDTH HEIGHT FRAMES");
  const std::string sensor = argv[1];
  const int width = std::atoi(argv[8]), height = std::atoi(argv[9]);
  covis::CameraParameters camera{.width = width, .height = height};
  camera.fx = std::atof(argv[2]);
  camera.fy = std::atof(argv[3]);
  camera.cx = std::atof(argv[4]);
  camera.cy = std::atof(argv[5]);
  camera.baseline = std::atof(argv[6]);
  const auto slam = covis::Slam::create({
      .sensor = sensor == "stereo" ? covis::SensorType::stereo
                : sensor == "rgbd" ? covis::SensorType::rgbd
                                   : covis::SensorType::monocular,
      .camera = camera,
      .timing = covis::Timing::deterministic,
      .vocabulary = argv[7],
  });
  if (!slam) return fail(slam.error());
  std::FILE* file = std::fopen(argv[10], "rb");
  if (!file) return fail(std::string(argv[10]) + ": it can't be read");
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  std::vector<uint8_t> grey(pixels), right(sensor == "stereo" ? pixels : 0);
  std::vector<float> depth(sensor == "rgbd" ? pixels : 0);
  for (int64_t stamp = 0; read(file, &stamp, sizeof stamp);) {
    if (!read(file, grey.data(), pixels) || !read(file, right.data(), right.size()) ||
        !read(file, depth.data(), depth.size() * sizeof(float)))
      return fail("a frame is cut short");
    covis::Frame frame{.stamp = stamp, .image = {grey.data(), width, height, width}};
    if (!right.empty()) frame.right = {right.data(), width, height, width};
    if (!depth.empty()) frame.depth = {depth.data(), width, height, width};
    const auto result = (*slam)->track(frame);
    if (!result) return fail(result.error());
    const covis::Pose& p = result->pose;
    std::printf("frame %lld %d", static_cast<long long>(stamp), result->tracked() ? 1 : 0);
    if (result->tracked())
      std::printf(" %.17g %.17g %.17g %.17g %.17g %.17g %.17g", p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw);
    std::printf("\n");
  }
  std::fclose(file);
  (*slam)->finish();
  const auto snapshot = (*slam)->snapshot();
  std::printf("map %zu %zu\n", snapshot->key_frames.size(), snapshot->points.size());
  for (const auto& k : snapshot->key_frames)
    std::printf("key_frame %lld 1 %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", static_cast<long long>(k.stamp),
                k.pose.x, k.pose.y, k.pose.z, k.pose.qx, k.pose.qy, k.pose.qz, k.pose.qw);
}
