// SPDX-License-Identifier: Apache-2.0
// A program that uses the installed library: the first RGB-D frame of a flat, chequered wall must start a map.
#include <covis/covis.h>

#include <cstdio>
#include <cstring>

int main() {
  std::vector<uint8_t> grey(640 * 480);
  for (int i = 0; i < 640 * 480; ++i) grey[i] = (i % 640 / 17 * 7919 + i / 640 / 17 * 104729) % 251;
  const std::vector<float> depth(640 * 480, 2.0f);

  auto slam = covis::Slam::create({
      .sensor = covis::SensorType::rgbd,
      .camera = {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240},
  });
  if (!slam) return std::printf("%s\n", slam.error().c_str()), 1;
  const auto result =
      (*slam)->track({.stamp = 0, .image = {grey.data(), 640, 480, 640}, .depth = {depth.data(), 640, 480, 640}});
  if (!result) return std::printf("%s\n", result.error().c_str()), 1;
  (*slam)->finish();
  std::printf("covis %s: %s, %zu points\n", covis::version(), covis::name(result->state),
              (*slam)->snapshot()->points.size());
  return result->tracked() && std::strcmp(covis::version(), COVIS_VERSION) == 0 ? 0 : 1;
}
