// SPDX-License-Identifier: Apache-2.0
// Recordings as a stream of frames: TUM RGB-D, KITTI odometry, EuRoC, an image folder, a video file, a camera.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/image.h"
#include "covis/core/sensor.h"
#include "covis/core/time.h"
#include "covis/geometry/camera.h"
#include "covis/io/trajectory.h"

namespace covis::io {

// One moment of the recording, decoded. Stereo images are rectified already; depth is in metres, registered to the
// image.
struct Frame {
  int64_t index = 0;  // in the recording, from 0; frames that can't be read keep their number
  Timestamp stamp = 0;
  ImageU8 image;  // grey, left
  ImageU8 right;  // stereo only
  ImageF depth;   // RGB-D only
};

enum class SequenceKind { automatic, tum, kitti, euroc, images, video, camera };

// The part of a recording to open, and the way. first < 0, stride < 1, decode_ahead < 1 are errors.
struct SequenceOptions {
  SequenceKind kind = SequenceKind::automatic;  // automatic: recognised from the folder
  std::optional<Sensor> sensor = std::nullopt;  // empty: the richest the recording allows
  std::filesystem::path camera_file = {};       // YAML for what the folder does not say; empty: none
  int decode_ahead = 4;                         // frames decoded ahead, in a thread of their own
  int64_t first = 0;                            // index of the first frame
  int64_t count = -1;                           // frames at most; -1: all
  int stride = 1;                               // every n-th frame
};

// The file of the truth of a recording.
struct Truth {
  std::filesystem::path file;
  std::filesystem::path stamps;  // KITTI: times.txt beside poses.txt; else empty
  // When the truth is of a body b (EuRoC) or another camera (KITTI colour): takes the camera of the images (rectified,
  // when stereo) to it.
  std::optional<SE3> T_bc;
};

class Sequence {
 public:
  virtual ~Sequence() = default;

  virtual SequenceKind kind() const = 0;
  virtual Sensor sensor() const = 0;
  // The camera of the images next() returns (after rectification), bf and depth filled in.
  virtual const Camera& camera() const = 0;
  virtual int64_t size() const = 0;       // frames, -1 when not known (camera, some videos)
  virtual double frame_rate() const = 0;  // Hz, from the stamps; 30 when not known
  virtual std::optional<Truth> truth() const = 0;
  // A one-line description: "TUM RGB-D folder, 1000 frames, 640x480".
  virtual std::string description() const = 0;
  // Files passed over on opening: "2 images are listed but missing".
  virtual std::vector<std::string> notes() const = 0;
  // The next frame; nothing at the end; an error for an unreadable frame, after which next() may be called again for
  // the one after it. `recycled` frames' memory is used again.
  virtual Result<std::optional<Frame>> next(Frame recycled = {}) = 0;
};

// Opens and checks what can be checked without decoding images (files listed exist, stamps rise, calibration is there
// and sound).
Result<std::unique_ptr<Sequence>> open_sequence(const std::string& path, const SequenceOptions& options);

// The truth of a sequence that has one: poses of its camera.
Result<Trajectory> load_truth(const Sequence& sequence);

}  // namespace covis::io
