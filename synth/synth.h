// SPDX-License-Identifier: Apache-2.0
// Synthetic recordings with exact truth: a camera moves smoothly through a textured world (a room, a corridor loop, a
// street loop, a desk, two equal rooms, a hall of equal posters) and each frame is rendered with its depth or its right
// image. Everything, the world included, is a pure function of the options, so that tests can use a world without
// files.
//
//   SynthOptions options;
//   options.world = "corridor";
//   options.sensor = "stereo";
//   auto synth = Synth::create(options);                 // an Error says which option is wrong
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
  int frames = 0;               // 0: as many as the world's path takes: once around and a little more, or to its end
  double way = 0;               // metres around the street's block, about; 0: its own; of other worlds 0
  double fps = 0;               // Hz; 0: the world's own (30; street 10)
  int width = 640;              // pixels
  int height = 480;             // pixels
  double focal = 0;             // pixels; 0: 0.625 of the image diagonal, which is 500 for 640x480
  double baseline = 0;     // metres between the stereo cameras, or a virtual one of RGB-D; 0: the world's own (0.11 and
                           // 0.08; street 0.54)
  double noise = 0;        // standard deviation of image noise at middle grey, grey levels
  double depth_noise = 0;  // strength of the depth sensor's errors: 0 exact, 1 like a Kinect
  double exposure = 0;     // greatest relative change of brightness over time, 0.3 is lively
  double blur = 0;         // time the shutter is open, milliseconds; motion blurs the image
  double distortion = 0;   // strength of the lens distortion: 0 none, 1 like a wide-angle lens; not for stereo
};

// The options by name ("synth.world", …), with their ranges.
Fields fields(SynthOptions& options);
// The worlds there are.
const std::vector<std::string>& synth_worlds();

class Synth {
 public:
  static Result<Synth> create(const SynthOptions& options);
  Synth(Synth&&) noexcept;
  Synth& operator=(Synth&&) noexcept;
  ~Synth();

  const SynthOptions& options() const;  // with the defaults filled in
  Sensor sensor() const;
  int frames() const;
  // The camera of the left image; bf is that of options().baseline, but 0 for monocular.
  const Camera& camera() const;
  double depth_units() const;    // a metre in 16-bit depth images fit for this world: 5000; street 256
  SE3 T_wc(int i) const;         // camera to world, exact, at the middle of the exposure
  Timestamp stamp(int i) const;  // i / fps, in whole microseconds
  // The image; for `right`, if asked for, the image of the stereo pair's other camera; for `depth`, if asked for,
  // z-depth in metres (0: none), registered to the left image. Frames may be rendered in any order, with the same
  // result.
  void render(int i, ImageU8& left, ImageU8* right, ImageF* depth);

 private:
  struct State;
  explicit Synth(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace covis
