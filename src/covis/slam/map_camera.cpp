// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/map_camera.h"

#include "covis/map/camera_change.h"

namespace covis {

Result<void> check_continued(const Map& map, Sensor sensor) {
  if (sensor != Sensor::monocular || metric_submaps(map).empty()) return {};
  return fail("the map is in metres, and this camera measures no depth: it can't be continued; localise in it only");
}

Pinhole for_sensor(Pinhole camera, Sensor sensor) {
  if (sensor != Sensor::rgbd) {
    camera.depth_noise = {};
    camera.registration = {};
  } else if (!camera.depth_noise.known()) {
    camera.depth_noise = DepthNoise::kinect();
  }
  return camera;
}

Pinhole camera_for(const Map& map, const Camera& made_by, const Camera& given, Sensor sensor) {
  const Pinhole saved = map.camera();
  Pinhole camera = same_lens(given, made_by) ? saved : given.pinhole;
  // The error of a pair's rectification is that of this pair alone.
  if (sensor != Sensor::stereo || made_by.pinhole.bf != given.pinhole.bf) camera.right_columns = {};
  if (camera.row_time == 0) camera.row_time = given.pinhole.row_time;
  if (sensor == Sensor::stereo) camera.residual = {};  // the columns of rectified pairs stay as they are
  // A registration or noise given for this recording goes before those that the map learned.
  if (sensor == Sensor::rgbd && given.pinhole.registration.any()) camera.registration = given.pinhole.registration;
  if (sensor == Sensor::monocular) camera.registration = saved.registration;
  const bool stereo_made_it = saved.bf > 0 && !saved.depth_noise.known();
  if (sensor == Sensor::monocular || (sensor == Sensor::rgbd && stereo_made_it)) {
    camera.bf = saved.baseline() * camera.fx;
    camera.depth_noise = saved.depth_noise;
    return camera;
  }
  camera.bf = given.pinhole.baseline() * camera.fx;
  camera.depth_noise = given.pinhole.depth_noise.known() ? given.pinhole.depth_noise : saved.depth_noise;
  return for_sensor(camera, sensor);
}

}  // namespace covis
