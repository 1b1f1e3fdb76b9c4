// SPDX-License-Identifier: Apache-2.0
#include "covis/storage/map_header_check.h"

#include <algorithm>
#include <cmath>

namespace covis::storage {

std::string problem_of(const Camera& camera) {
  constexpr int kMaxSide = 1'000'000;      // pixels, as for positions of features
  constexpr double kMaxCoefficient = 1e9;  // no lens is near
  const auto bounded = [](double v) { return std::abs(v) <= kMaxCoefficient; };
  if (!valid_camera(camera.pinhole) || !std::all_of(camera.coefficients.begin(), camera.coefficients.end(), bounded)) {
    return "its camera is not valid";
  }
  if (camera.width < 1 || camera.height < 1 || camera.width > kMaxSide || camera.height > kMaxSide)
    return "its camera has no image size";
  const int distortion = static_cast<int>(camera.distortion);
  if (distortion < 0 || distortion > static_cast<int>(Distortion::kannala_brandt)) return "its lens is unknown";
  return {};
}

std::string problem_of(const MapHeader& h) {
  constexpr size_t kVocabularyDigits = 16;  // hexadecimal digits of 64 bits
  if (std::string problem = storage::problem_of(h.camera); !problem.empty()) return problem;
  const int sensor = static_cast<int>(h.sensor);
  if (sensor < 0 || sensor > static_cast<int>(Sensor::rgbd)) return "its sensor is unknown";
  if (!valid_pyramid(h.levels, h.factor)) return "its pyramid is not valid";
  // It is printed, so that nothing but digits may be in it.
  if (h.vocabulary.size() > kVocabularyDigits ||
      h.vocabulary.find_first_not_of("0123456789abcdef") != std::string::npos)
    return "the checksum of its vocabulary is no number";
  return {};
}

}  // namespace covis::storage
