// SPDX-License-Identifier: Apache-2.0
// Synthetic recordings with exact ground truth: a camera moves smoothly through a textured world (a room, a corridor
// loop, a street loop, a desk, two equal rooms, a hall of equal posters) and each frame is rendered with its depth or
// its right image. Everything, the world included, is a pure function of the options, so that tests can use a world
// without files.
//
//   SynthOptions options;
//   options.world = "corridor";
//   options.sensor = "stereo";
// an Error names the wrong option
//   for (int i = 0; i < synth->frames(); ++i) synth->render(i, left, &right, nullptr);
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/fields.h"
#include "covis/core/image.h"
#include "covis/core/sensor.h"
#include "covis/core/time.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"

namespace covis {

struct SynthOptions {
  std::string world = "room";   // room, corridor, street, desk, twins, posters
  std::string sensor = "rgbd";  // mono, stereo, rgbd
  int seed = 1;                 // seed of the world, the path and all noise
  int light = 0;                // 0: as painted; else number of another light over the same world
  int moving = 0;               // number of things that move before the camera: people, cars, books
  int frames = 0;               // 0: the whole path of the world, a little more than one round or up to its end
  double way = 0;               // approximate length of the street's loop, metres; 0: the default; other worlds: 0
  double fps = 0;               // Hz; 0: the world's default (30; street 10)
  int width = 640;              // pixels
  int height = 480;             // pixels
  double focal = 0;             // focal length, pixels; 0: 0.625 of the image diagonal (500 for 640x480)
  // Baseline of the stereo cameras, or virtual one of RGB-D, metres; 0: the world's default (0.11 and 0.08; street
  // 0.54).
  double baseline = 0;
  double noise = 0;         // standard deviation of image noise at middle grey, grey levels
  double depth_noise = 0;   // strength of the depth sensor's errors: 0 exact, 1 Kinect-like
  double exposure = 0;      // greatest relative change of brightness over time; 0.3 is strong
  double right_gain = 1;    // brightness of the stereo pair's right image by that of the left one
  double right_offset = 0;  // and what is added to it, grey levels
  // How the stereo pair's right camera is turned from where a rectified pair has it, degrees: to the right, down, and
  // clockwise.
  double right_yaw = 0, right_pitch = 0, right_roll = 0;
  double blur = 0;        // time the shutter is open, milliseconds; motion blurs the image
  double distortion = 0;  // strength of the lens distortion: 0 none, 1 wide-angle lens; not for stereo
};

// Lists the options by name ("synth.world", …) with their ranges.
Fields fields(SynthOptions& options);
// Returns the names of the worlds.
const std::vector<std::string>& synth_worlds();

class Synth {
 public:
  static Result<Synth> create(const SynthOptions& options);
  Synth(Synth&&) noexcept;
  Synth& operator=(Synth&&) noexcept;
  ~Synth();

  const SynthOptions& options() const;  // the options, with defaults filled in
  Sensor sensor() const;
  int frames() const;
  // Returns the left image's camera; its bf is that of options().baseline, but 0 for monocular.
  const Camera& camera() const;
  double depth_units() const;    // units per metre of 16-bit depth images of this world: 5000; street 256
  SE3 T_wc(int i) const;         // camera to world, exact, at the middle of the exposure
  Timestamp stamp(int i) const;  // i / fps, in whole microseconds
  // Renders the (left) image and, if requested, the stereo pair's right image in `right`, and the z-depth in metres (0:
  // none), registered to the left image, in `depth`. Frames may be rendered in any order, with the same result.
  void render(int i, ImageU8& left, ImageU8* right, ImageF* depth);

 private:
  struct State;
  explicit Synth(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace covis
