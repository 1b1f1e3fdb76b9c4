// SPDX-License-Identifier: Apache-2.0
// The map and the trajectory at one moment, as plain values that never change: for viewers, exports and programs that
// look at the map while tracking goes on. Flat lists; what refers to an entry of another list does so by its index.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/types.h"

namespace covis {

struct MapSnapshot {
  // A map of its own within the whole. There is more than one when the camera was lost and what was mapped before and
  // after has not been joined (yet).
  struct Submap {
    int id = 0;
    bool loaded = false;  // it came from a file, or was joined to one that did
    size_t frames = 0;    // frames of the recording that have a pose in it
    size_t key_frames = 0, points = 0;
  };

  struct KeyFrame {
    uint64_t id = 0;    // counts key frames as they are made; the file keeps it
    int64_t frame = 0;  // number of the frame, counted from 0 by track(); of the recording that made it if loaded
    int64_t stamp = 0;  // nanoseconds
    Pose pose;
    int submap = 0;       // id
    int64_t parent = -1;  // index into key_frames, in the submap's spanning tree; -1: its root
    int camera = 0;       // index into cameras; 0 too for one of an old map that does not say which camera made it
  };

  // An edge of the covisibility graph, or one that a loop made. Indices into key_frames, a < b.
  struct Edge {
    uint32_t a = 0, b = 0;
    int shared = 0;     // points that both observe; an edge without a loop has 15 at least
    bool loop = false;  // a loop was closed between them
  };

  struct Point {
    uint64_t id = 0;             // of this run: a map saved and loaded again has other ids
    double x = 0, y = 0, z = 0;  // metres
    int submap = 0;              // id
    Colour colour = kNoColour;   // the mean over the key frames that see it and whose images came with colours
  };

  // A key frame observes a point. Indices into key_frames and points.
  struct Observation {
    uint32_t key_frame = 0, point = 0;
    float u = 0, v = 0;  // pixels of the key frame's image as it was given (of the rectified one where pairs are
                         // rectified), which MapSnapshot::cameras[KeyFrame::camera] took
  };

  uint64_t revision = 0;    // rises when the map or the trajectory changes
  CameraParameters camera;  // as Slam::camera()
  // The cameras that made key frames: the first is `camera`, the others those of a map that was continued with another
  // camera, or merged from maps of several.
  std::vector<CameraParameters> cameras;
  std::vector<Submap> submaps;       // loaded ones first, then those with more frames, then the older ones
  std::vector<KeyFrame> key_frames;  // in the order in which they were made
  std::vector<Edge> edges;
  std::vector<Point> points;
  std::vector<Observation> observations;  // key frame by key frame
  // Frames that have a pose, with every correction so far, by rising stamp; without those that were tentative and
  // proved wrong. A frame that got no pose when it was tracked may have one now: it is located from later ones where
  // the map reaches it.
  std::vector<TrajectoryPose> trajectory;
};

}  // namespace covis
