// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace covis {

enum class Sensor { monocular, stereo, rgbd };

constexpr std::string_view name(Sensor sensor) {
  switch (sensor) {
    case Sensor::monocular:
      return "mono";
    case Sensor::stereo:
      return "stereo";
    case Sensor::rgbd:
      return "rgbd";
  }
  return "";
}

}  // namespace covis
