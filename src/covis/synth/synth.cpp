// SPDX-License-Identifier: Apache-2.0
#include "covis/synth/synth.h"

#include <algorithm>
#include <cmath>

#include "covis/synth/renderer.h"
#include "covis/synth/world.h"

namespace covis {

struct Synth::State {
  SynthOptions options;
  Sensor sensor;
  Camera camera;
  synth::World world;
  synth::Renderer renderer;
  ImageF tone, depth;
};

Fields fields(SynthOptions& o) {
  return {
      {"synth.world", &o.world, "world to render: room, corridor, street, desk"},
      {"synth.sensor", &o.sensor, "camera to imitate: mono, stereo, rgbd"},
      {"synth.seed", &o.seed, "seed of the world, the path and all noise", 0, 2147483647},
      {"synth.frames", &o.frames, "number of frames; 0: once around the world's path and a little more", 0, 1000000},
      {"synth.fps", &o.fps, "frames a second; 0: the world's own (30; street 10)", 0, 1000},
      {"synth.width", &o.width, "image width, pixels", 64, 4096},
      {"synth.height", &o.height, "image height, pixels", 64, 4096},
      {"synth.focal", &o.focal, "focal length, pixels; 0: 0.625 of the image diagonal (500 for 640x480)", 0, 20000},
      {"synth.baseline", &o.baseline, "distance of the stereo cameras, metres; 0: the world's own (0.11; street 0.54)",
       0, 10},
      {"synth.noise", &o.noise, "standard deviation of image noise at middle grey, grey levels", 0, 50},
      {"synth.depth_noise", &o.depth_noise, "strength of the depth sensor's errors; 0: exact, 1: like a Kinect", 0, 10},
      {"synth.exposure", &o.exposure, "greatest relative change of brightness over time", 0, 0.9},
      {"synth.blur", &o.blur, "time the shutter is open, milliseconds; motion blurs the image", 0, 100},
      {"synth.distortion", &o.distortion,
       "strength of the lens distortion; 0: none, 1: like a wide-angle lens; mono and rgbd only", 0, 1.5},
  };
}

const std::vector<std::string>& synth_worlds() {
  static const std::vector<std::string> worlds{"room", "corridor", "street", "desk"};
  return worlds;
}

namespace {

Result<void> check_ranges(SynthOptions options) {
  for (const Field& field : fields(options)) {
    double value = 0;
    if (const auto* i = std::get_if<int*>(&field.value)) {
      value = **i;
    } else if (const auto* d = std::get_if<double*>(&field.value)) {
      value = **d;
    } else {
      continue;
    }
    if (!(value >= field.min && value <= field.max)) {
      return fail(field.name + " is " + std::to_string(value) + "; it must be from " + std::to_string(field.min) +
                  " to " + std::to_string(field.max));
    }
  }
  return {};
}

synth::World make_world(const SynthOptions& options) {
  const uint64_t seed = static_cast<uint64_t>(options.seed);
  if (options.world == "corridor") return synth::make_corridor(seed);
  if (options.world == "desk") return synth::make_desk(seed);
  if (options.world == "street") return synth::make_street(seed);
  return synth::make_room(seed);
}

}  // namespace

Result<Synth> Synth::create(const SynthOptions& given) {
  if (auto ok = check_ranges(given); !ok) return tl::unexpected(ok.error());
  SynthOptions options = given;
  synth::World world = make_world(options);
  if (options.fps <= 0) options.fps = world.fps;
  if (options.frames <= 0) options.frames = static_cast<int>(std::lround(world.frames * options.fps / world.fps));
  if (options.focal <= 0) options.focal = 0.625 * std::hypot(options.width, options.height);
  if (options.baseline <= 0) options.baseline = world.baseline;
  const Sensor sensor = options.sensor == "stereo" ? Sensor::stereo
                        : options.sensor == "mono" ? Sensor::monocular
                                                   : Sensor::rgbd;
  Camera camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.pinhole = {options.focal, options.focal, 0.5 * (options.width - 1), 0.5 * (options.height - 1), 0};
  if (sensor == Sensor::stereo) camera.pinhole.bf = options.focal * options.baseline;
  if (sensor == Sensor::rgbd) camera.pinhole.bf = options.focal * 0.08;
  auto renderer = synth::Renderer::create(camera);
  if (!renderer) return tl::unexpected(renderer.error());
  return Synth(
      std::unique_ptr<State>(new State{options, sensor, camera, std::move(world), std::move(*renderer), {}, {}}));
}

Synth::Synth(std::unique_ptr<State> state) : state_(std::move(state)) {}
Synth::Synth(Synth&&) noexcept = default;
Synth& Synth::operator=(Synth&&) noexcept = default;
Synth::~Synth() = default;

const SynthOptions& Synth::options() const { return state_->options; }
Sensor Synth::sensor() const { return state_->sensor; }
int Synth::frames() const { return state_->options.frames; }
const Camera& Synth::camera() const { return state_->camera; }
SE3 Synth::T_wc(int i) const { return state_->world.path.at(i / state_->options.fps).T_wc(); }
Timestamp Synth::stamp(int i) const { return from_seconds(i / state_->options.fps); }

void Synth::render(int i, ImageU8& left, ImageU8* right, ImageF* depth) {
  State& s = *state_;
  const SE3 pose = T_wc(i);
  const auto develop = [&](ImageU8& image) {
    image.resize(s.camera.width, s.camera.height);
    for (int y = 0; y < s.camera.height; ++y) {
      const float* from = s.tone.row(y);
      uint8_t* to = image.row(y);
      for (int x = 0; x < s.camera.width; ++x) to[x] = static_cast<uint8_t>(std::clamp(from[x] + 0.5f, 0.0f, 255.0f));
    }
  };
  if (right) {
    s.renderer.render(s.world.scene, pose * SE3(Eigen::Matrix3d::Identity(), {s.options.baseline, 0, 0}), s.tone,
                      s.depth);
    develop(*right);
  }
  s.renderer.render(s.world.scene, pose, s.tone, s.depth);
  develop(left);
  if (depth) {
    depth->resize(s.camera.width, s.camera.height);
    for (int y = 0; y < s.camera.height; ++y) std::copy_n(s.depth.row(y), s.camera.width, depth->row(y));
  }
}

}  // namespace covis
