// SPDX-License-Identifier: Apache-2.0
// The noise of a depth sensor: the standard deviation of a depth z along the optical axis is a + b z^2. The first term
// is that of the sensor's own steps, the second that of a triangulation, as structured light and active stereo make
// one. Sources: Khoshelham and Elberink, "Accuracy and resolution of Kinect depth data", Sensors 2012; Nguyen, Izadi,
// Lovell, "Modeling Kinect sensor noise", 3DIMPVT 2012; Keselman et al., "Intel RealSense stereoscopic depth cameras",
// CVPRW 2017.
#pragma once

#include <cmath>
#include <limits>

namespace covis {

struct DepthNoise {
  double a = 0;  // metres
  double b = 0;  // 1 / metres

  bool known() const { return a > 0 || b > 0; }
  bool valid() const { return std::isfinite(a) && std::isfinite(b) && a >= 0 && b >= 0; }
  // Standard deviation of a depth, metres.
  double sigma(double z) const { return a + b * z * z; }
  // The greatest depth whose sigma is no more than `share` of it, metres; 0: there is none.
  double reach(double share) const {
    const double root2 = share * share - 4 * a * b;
    if (root2 < 0) return 0;
    return b > 0 ? (share + std::sqrt(root2)) / (2 * b) : std::numeric_limits<double>::infinity();
  }
  DepthNoise scaled(double factor) const { return {a * factor, b * factor}; }
  friend bool operator==(const DepthNoise&, const DepthNoise&) = default;

  static DepthNoise kinect() { return {0.001, 0.0015}; }
  static DepthNoise realsense() { return {0.001, 0.003}; }
  static DepthNoise exact() { return {0.0001, 0.00005}; }
};

}  // namespace covis
