// SPDX-License-Identifier: Apache-2.0
#include "covis/io/outputs.h"

#include <algorithm>
#include <bit>
#include <string>

#include "covis/core/atomic_file.h"

namespace covis::io {
namespace {

static_assert(std::endian::native == std::endian::little, "append() copies floats as they are");

void append(std::string& text, const Eigen::Vector3d& vector) {
  const Eigen::Vector3f v = vector.cast<float>();
  text.append(reinterpret_cast<const char*>(v.data()), sizeof(float) * 3);
}

}  // namespace

Result<void> write_ply(const std::filesystem::path& file, const std::vector<CloudPoint>& points, CloudUnit unit) {
  const bool normals =
      std::any_of(points.begin(), points.end(), [](const CloudPoint& p) { return !p.normal.isZero(); });
  const bool colours =
      normals || std::any_of(points.begin(), points.end(), [](const CloudPoint& p) { return p.colour != kNoColour; });
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment map points, " +
                     std::string(unit == CloudUnit::metres ? "metres" : "units of the map") + "\nelement vertex " +
                     std::to_string(points.size()) + "\nproperty float x\nproperty float y\nproperty float z\n";
  if (normals) text += "property float nx\nproperty float ny\nproperty float nz\n";
  if (colours) text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  text += "end_header\n";
  for (const CloudPoint& point : points) {
    append(text, point.position);
    if (normals) append(text, point.normal);
    if (colours) text.append(point.colour.begin(), point.colour.end());
  }
  return write_atomically(file, text);
}

}  // namespace covis::io
