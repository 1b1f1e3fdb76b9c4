// SPDX-License-Identifier: Apache-2.0
#include "check_sensor.h"

#include <algorithm>
#include <iterator>

#include "covis/core/quantile.h"
#include "covis/slam/map_camera.h"

namespace covis::app {
void SensorSample::add(const io::Frame& frame) {
  using Pace = MotionDepthCheck::Pace;
  constexpr int64_t kCompareEvery = 2;
  if (sensor_ == Sensor::monocular) return;
  const int64_t at = count_++ % step_;
  if (at >= kLength) return;
  if (at == 0) sample_.emplace(camera_, sensor_);
  Sample& s = *sample_;
  const FeaturesPtr features = sensor_ == Sensor::stereo ? s.frontend.stereo(frame.image.view(), frame.right.view())
                                                         : s.frontend.rgbd(frame.image.view(), frame.depth.view());
  s.monitor.add_frame(frame.index, *features, s.frontend.row_error());
  if (sensor_ == Sensor::rgbd)
    s.monitor.add_images(frame.index, frame.image.view(), frame.depth.view(), camera_.pinhole.registration);
  if (at % kCompareEvery == 0) {
    for (const DepthAgainstMotion& compared :
         s.check.add(features->for_key_frame(), for_sensor(camera_.pinhole, sensor_),
                     s.monitor.doubts_depth() ? Pace::every_view : Pace::usual))
      s.monitor.add_comparison(frame.index, compared);
    std::copy_if(features->depth.begin(), features->depth.end(), std::back_inserter(depths_),
                 [](float depth) { return depth > 0; });
  }
  for (const SensorWarning& warning : s.monitor.take_warnings()) {
    const bool known = std::any_of(warnings_.begin(), warnings_.end(),
                                   [&](const SensorWarning& w) { return w.doubt == warning.doubt; });
    if (!known) warnings_.push_back(warning);
  }
}

std::optional<SensorSample::Depths> SensorSample::depths() const {
  if (depths_.empty()) return std::nullopt;
  return Depths{quantile(depths_, 0.1), quantile(depths_, 0.5), quantile(depths_, 0.9)};
}

}  // namespace covis::app
