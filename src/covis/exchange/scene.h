// SPDX-License-Identifier: Apache-2.0
// A submap as other programs of the field want it: pinhole cameras, views with poses, and points with the pixels they
// were seen at. Pixels are undistorted, with pixel centres at whole numbers; lengths are those of the map. Images
// are named, not held.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "covis/core/time.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/measurement.h"
#include "covis/geometry/se3.h"
#include "covis/map/map.h"
#include "covis/types.h"

namespace covis::exchange {

// The centre of the first pixel for COLMAP and those who follow it; here it is at (0, 0).
inline constexpr double kPixelCentre = 0.5;

struct SceneCamera {
  Camera given;     // the camera that took the images
  Pinhole refined;  // its intrinsics as the map has them
  Pinhole pinhole;  // the camera of the views, whose images have the size of those taken

  bool sees(double u, double v) const;
};

struct SceneView {
  uint32_t serial = 0;  // that of the key frame
  uint32_t camera = 0;  // index into Scene::cameras
  Timestamp stamp = 0;
  SE3 T_cw;
  std::string image;  // name of its image file, without a folder; empty: it has none (write_images())
  struct Keypoint {
    double u = 0, v = 0;
    Eigen::Vector2d rolled = Eigen::Vector2d::Zero();  // from there to where the undistorted image shows it
    uint32_t point = 0;                                // index into Scene::points
    double scale = 1;                                  // pixels of its image that a pixel of its pyramid level is wide
    Disparity disparity{};                             // as the map's own camera has it
    bool aligned = false;                              // align_keypoints() found u and v

    Eigen::Vector2d in_image() const { return Eigen::Vector2d(u, v) + rolled; }
  };
  std::vector<Keypoint> keypoints;  // those that show a point
};

struct ScenePoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit length, to those who see it
  Colour colour = kNoColour;
  double error = 0;  // mean distance of its keypoints from its projections, pixels
  struct Sight {
    uint32_t view = 0, keypoint = 0;  // indices into Scene::views and SceneView::keypoints
  };
  std::vector<Sight> seen;  // in the order of the views
};

struct Scene {
  std::vector<SceneCamera> cameras;  // the map's own first
  std::vector<SceneView> views;
  std::vector<ScenePoint> points;
};

// The submaps of a map, those with more key frames first; images are called by the serial of their key frame, in six
// digits. Keypoints that lie outside the undistorted image are left out. `given`: the map's own camera as it was given.
std::vector<Scene> scenes_of(const Map& map, const Camera& given);

// Fills in the points' `seen` and `error` anew.
void find_sights(Scene& scene);

// How far an observation may lie from its point's projection: COLMAP's own bound (Mapper.filter_max_reproj_error).
inline constexpr double kMaxObservationError = 4;  // pixels

struct LeftOut {
  size_t observations = 0;  // farther off than kMaxObservationError, or of a point behind the camera
  size_t points = 0;        // seen by fewer than two views: by a depth alone, or once the others are left out
};

// Leaves out those observations, then those points, for programs that know points by their observations alone. The
// other points are numbered anew; positions and poses stay.
LeftOut keep_tracks(Scene& scene);

// The mean of the points' errors, pixels; 0 without a point.
double mean_error(const Scene& scene);

// The name of a key frame's image, where nothing else is known of it.
std::string image_name(uint32_t serial);

// The scene through cameras of one focal length each, whose principal points are their images' centres.
Scene centred(const Scene& scene);

// The direction away from the ground as the cameras were held: the mean of their upward axes.
Eigen::Vector3d upward(const Scene& scene);

// A frame that shows a scene from above: origin is the first view's centre, x to the right of where it looks, y where
// it looks, z upward(). p_here = result * (p_world - origin).
Eigen::Matrix3d seen_from_above(const Scene& scene);

}  // namespace covis::exchange
