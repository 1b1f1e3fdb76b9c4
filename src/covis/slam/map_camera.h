// SPDX-License-Identifier: Apache-2.0
// The camera of a map that is put in place, when it was made by this camera or by another.
#pragma once

#include "covis/core/error.h"
#include "covis/core/sensor.h"
#include "covis/geometry/camera.h"
#include "covis/map/map.h"

namespace covis {

// An error when the camera would add to a map in metres what has no unit, for it measures no depth.
Result<void> check_continued(const Map& map, Sensor sensor);

// The camera in which a map that `made_by` made is expressed for `given`. With the same lens it keeps what was refined,
// but for a residual distortion where pairs are rectified. The baseline and the noise of depths are those of `given`,
// but for two cases: a camera without depth leaves them as they are, and depths of a stereo camera are not weighed by
// the noise of a depth sensor, so that a depth sensor's are weighed as disparities there.
Pinhole camera_for(const Map& map, const Camera& made_by, const Camera& given, Sensor sensor);

// A depth sensor has a noise, which is a Kinect's where none is given; others have neither that nor a registration.
Pinhole for_sensor(Pinhole camera, Sensor sensor);

}  // namespace covis
