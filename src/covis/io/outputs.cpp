// SPDX-License-Identifier: Apache-2.0
#include "covis/io/outputs.h"

#include <bit>

#include "covis/core/atomic_file.h"

namespace covis::io {

static_assert(std::endian::native == std::endian::little, "write_ply copies floats as they are");

Result<void> write_ply(const std::filesystem::path& file, const std::vector<Eigen::Vector3d>& points) {
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment map points, metres\nelement vertex " +
                     std::to_string(points.size()) +
                     "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3f p = point.cast<float>();
    text.append(reinterpret_cast<const char*>(p.data()), sizeof(float) * 3);
  }
  return write_atomically(file, text);
}

}  // namespace covis::io
