// SPDX-License-Identifier: Apache-2.0
// Recordings as streams of frames: TUM RGB-D, KITTI odometry, EuRoC, TartanAir, OpenLORIS-Scene, RGB-D image
// folders, a ROS bag, an image folder, a video
// file, a camera.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/image.h"
#include "covis/core/sensor.h"
#include "covis/core/time.h"
#include "covis/geometry/camera.h"
#include "covis/io/images.h"
#include "covis/io/trajectory.h"

namespace covis::io {

// One decoded frame of a recording. Stereo images are rectified already; depth is in metres, registered to the image.
struct Frame {
  int64_t index = 0;  // index in the recording, from 0; unreadable frames keep their number
  Timestamp stamp = 0;
  ImageU8 image;  // grey, left
  ImageU8 right;  // grey, right; stereo only
  ImageF depth;   // metres; RGB-D only
};

enum class SequenceKind { automatic, tum, kitti, euroc, tartanair, openloris, open3d, bag, images, video, camera };

// Topics of a bag by name; an empty one is chosen by names and types.
struct TopicNames {
  std::string image = {};  // or left image
  std::string right = {}, depth = {};

  bool any() const { return !image.empty() || !right.empty() || !depth.empty(); }
};

// Selects the source and the frames to read. first < 0, stride < 1 and decode_ahead < 1 are errors.
struct SequenceOptions {
  SequenceKind kind = SequenceKind::automatic;  // automatic: recognised from the folder
  std::optional<Sensor> sensor = std::nullopt;  // nullopt: the richest one that the recording supports
  std::filesystem::path camera_file = {};       // YAML for data that the folder lacks; empty: none
  bool uncalibrated = false;                    // true: images and videos need no calibration, see Sequence::camera()
  TopicNames topics = {};                       // a bag's; an error for another kind
  int decode_ahead = 4;                         // number of frames decoded ahead, in a thread of its own
  int64_t first = 0;                            // index of the first frame
  int64_t count = -1;                           // greatest number of frames; -1: all
  int stride = 1;                               // only every n-th frame is read
  bool skip_bad = false;  // true: frames that can't be used are left out, however many they are (bad_frames.h)
  const std::atomic<int>* stop = nullptr;  // not zero: next() of a camera no longer waits; may be null
};

// State of a live camera after the last call of next(); recordings have that of a camera that is there.
struct LiveStatus {
  // gone: it gives no images, and is waited for; failed: it can't be used any more, and next() gives the end.
  enum class State { there, gone, failed };
  State state = State::there;
  int64_t dropped = 0;  // number of frames that were older than another when they could have been taken
};

// Files with the ground truth of a recording, if there are any.
struct Truth {
  std::filesystem::path file;
  // Pose of the images' camera (rectified, when stereo) in the body frame b (EuRoC) or in the camera (KITTI colour)
  // whose poses the ground truth gives.
  std::optional<SE3> T_bc;
  // Reads it, where read_trajectory() alone can't; empty: it can.
  std::function<Result<Trajectory>()> read = {};
};

class Sequence {
 public:
  virtual ~Sequence() = default;

  virtual SequenceKind kind() const = 0;
  virtual Sensor sensor() const = 0;
  // Returns the camera of the images from next() (after rectification), including bf. Opened `uncalibrated`, without a
  // camera file and where no calibration lies beside it, it has a size alone: its focal lengths are 0.
  virtual const Camera& camera() const = 0;
  virtual int64_t size() const = 0;       // number of frames; -1 when unknown (camera, some videos)
  virtual double frame_rate() const = 0;  // Hz, of the frames that next() gives; 30 when unknown
  virtual std::optional<Truth> truth() const = 0;
  // Returns a one-line description: "TUM RGB-D folder, 1000 frames, 640x480".
  virtual std::string description() const = 0;
  // Returns what was skipped on opening, "2 images are listed but missing", and, behind the last frame, what lacked.
  virtual std::vector<std::string> notes() const = 0;
  // Those of the notes by which more than 1 % of the recording is lost.
  virtual std::vector<std::string> losses() const { return {}; }
  // Returns the next frame, nullopt at the end, or an error for an unreadable frame, after which next() may be called
  // again for the frame after it. The memory of `recycled` is reused.
  virtual Result<std::optional<Frame>> next(Frame recycled = {}) = 0;
  // Returns the image that Frame::image of a frame was made of, in colour if it has any, and rectified if that is. An
  // error where it can't be read (again), as that of a camera. For one thread at a time, which may be another than that
  // of next(). Of a video, frames asked for in their order take least time.
  virtual Result<Picture> picture(int64_t frame) = 0;
  virtual LiveStatus live() const { return {}; }
  // False when picture() would give a grey image or none.
  virtual bool may_have_colours(int64_t frame) const = 0;
};

// Says why frames can hardly come at this rate, in Hz: stamps of another unit than they were read in.
std::optional<std::string> doubt_about_rate(double rate);
// The same of a sequence of which every stride-th frame was opened.
std::optional<std::string> doubt_about_rate(const Sequence& sequence, int stride);

// Opens a recording and checks all that can be checked without decoding images: listed files exist, stamps are
// ascending, the calibration exists and is valid.
Result<std::unique_ptr<Sequence>> open_sequence(const std::string& path, const SequenceOptions& options);

// Reads the ground truth of a sequence that has one: poses of its camera.
Result<Trajectory> load_truth(const Sequence& sequence);

}  // namespace covis::io
