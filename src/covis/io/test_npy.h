// SPDX-License-Identifier: Apache-2.0
// For tests: array files as NumPy writes them.
#pragma once

#include <string>
#include <vector>

namespace covis::io {

inline std::string npy_bytes(const std::vector<float>& values, const std::string& shape,
                             const std::string& descr = "'<f4'", const std::string& fortran = "False",
                             int version = 1) {
  std::string header = "{'descr': " + descr + ", 'fortran_order': " + fortran + ", 'shape': " + shape + ", }";
  const size_t before = version == 1 ? 10 : 12;
  header.append((64 - (before + header.size() + 1) % 64) % 64, ' ');
  header += '\n';
  std::string bytes = "\x93NUMPY";
  bytes += static_cast<char>(version);
  bytes += '\0';
  for (size_t i = 0; i < before - 8; ++i) bytes += static_cast<char>(header.size() >> (8 * i) & 0xff);
  bytes += header;
  for (const float value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  return bytes;
}

}  // namespace covis::io
