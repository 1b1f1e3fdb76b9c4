// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace covis {

enum class Sensor { monocular, stereo, rgbd };

}  // namespace covis
