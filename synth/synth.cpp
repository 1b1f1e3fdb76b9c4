// SPDX-License-Identifier: Apache-2.0
#include "synth/synth.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "covis/core/random.h"
#include "covis/geometry/se3.h"
#include "synth/render/lighting.h"
#include "synth/render/renderer.h"
#include "synth/render/sensor_effects.h"
#include "synth/things/moving_things.h"
#include "synth/worlds/world.h"

namespace covis {

namespace {
// Stages for hash_seed.
enum Stage : uint64_t { kLens = 11, kExposure, kNoise, kRightNoise, kDepthNoise, kLight, kMoving };
}  // namespace

struct Synth::State {
  SynthOptions options;
  Sensor sensor;
  Camera camera;
  synth::World world;
  synth::Renderer renderer;
  std::optional<synth::MovingThings> moving;
  ImageF tone, depth, scratch;

  // Renders the image of the camera at T_camera in the frame of the left one; its depth is left in `depth`.
  void take(double seconds, const SE3& T_camera, Stage noise_stage, int frame, ImageU8& image);
};

Fields fields(SynthOptions& o) {
  return {
      {"synth.world", &o.world, "world to render: room, corridor, street, desk, twins, posters"},
      {"synth.sensor", &o.sensor, "camera to imitate: mono, stereo, rgbd"},
      {"synth.seed", &o.seed, "seed of the world, the path and all noise", 0, 2147483647},
      {"synth.light", &o.light, "light over the world; 0: as painted, 1 and more: others (sun, lamps, shadows)", 0,
       2147483647},
      {"synth.moving", &o.moving, "things that move before the camera: people, on the street cars, over the desk books",
       0, 50},
      {"synth.frames", &o.frames, "number of frames; 0: as many as the world's path takes", 0, 1000000},
      {"synth.way", &o.way, "approximate length of the street's loop, metres; 0: the default, some 310", 0, 20000},
      {"synth.fps", &o.fps, "frames per second; 0: the world's default (30; street 10)", 0, 1000},
      {"synth.width", &o.width, "image width, pixels", 64, 4096},
      {"synth.height", &o.height, "image height, pixels", 64, 4096},
      {"synth.focal", &o.focal, "focal length, pixels; 0: 0.625 of the image diagonal (500 for 640x480)", 0, 20000},
      {"synth.baseline", &o.baseline,
       "distance of the stereo cameras, or the virtual one of an RGB-D camera, metres; 0: the world's default (0.11 "
       "and "
       "0.08; street 0.54)",
       0, 10},
      {"synth.noise", &o.noise, "standard deviation of image noise at middle grey, grey levels", 0, 50},
      {"synth.depth_noise", &o.depth_noise, "strength of the depth sensor's errors; 0: exact, 1: like a Kinect", 0, 10},
      {"synth.exposure", &o.exposure, "greatest relative change of brightness over time", 0, 0.9},
      {"synth.right_gain", &o.right_gain, "brightness of the right image by that of the left one; stereo", 0.1, 10},
      {"synth.right_yaw", &o.right_yaw, "by which the right camera is turned to the right, degrees; stereo", -5, 5},
      {"synth.right_pitch", &o.right_pitch, "and turned down", -5, 5},
      {"synth.right_roll", &o.right_roll, "and clockwise", -5, 5},
      {"synth.right_offset", &o.right_offset, "what is added to the right image, grey levels; stereo", -200, 200},
      {"synth.blur", &o.blur, "time the shutter is open, milliseconds; motion blurs the image", 0, 100},
      {"synth.distortion", &o.distortion,
       "strength of the lens distortion; 0: none, 1: like a wide-angle lens; mono and rgbd only", 0, 1.5},
  };
}

const std::vector<std::string>& synth_worlds() {
  static const std::vector<std::string> worlds{"room", "corridor", "street", "desk", "twins", "posters"};
  return worlds;
}

namespace {

Result<Sensor> check(SynthOptions& options) {
  for (const Field& field : fields(options)) {  // setting a field to its own value checks its range
    if (auto ok = set_field(fields(options), field.name, field_text(field)); !ok) return tl::unexpected(ok.error());
  }
  const auto& worlds = synth_worlds();
  if (std::find(worlds.begin(), worlds.end(), options.world) == worlds.end()) {
    return fail("there is no world '" + options.world + "'; did you mean '" + nearest_name(options.world, worlds) +
                "'? There are room, corridor, street, desk, twins and posters");
  }
  if (options.sensor == "stereo" && options.distortion > 0) {
    return fail("synth.distortion is " + std::to_string(options.distortion) +
                ", but stereo pairs are rendered rectified; leave it at 0, or take the sensor mono or rgbd");
  }
  if (options.way > 0 && options.world != "street") {
    return fail("synth.way is " + std::to_string(options.way) +
                ", but only the street's can be made longer; leave it at 0");
  }
  if (options.sensor == "mono") return Sensor::monocular;
  if (options.sensor == "stereo") return Sensor::stereo;
  if (options.sensor == "rgbd") return Sensor::rgbd;
  return fail("there is no sensor '" + options.sensor + "'; did you mean '" +
              nearest_name(options.sensor, {"mono", "stereo", "rgbd"}) + "'? There are mono, stereo and rgbd");
}

Camera make_camera(const SynthOptions& o, Sensor sensor) {
  Camera camera;
  camera.width = o.width;
  camera.height = o.height;
  camera.pinhole = {o.focal, o.focal, 0.5 * (o.width - 1), 0.5 * (o.height - 1), 0};
  if (sensor != Sensor::monocular) camera.pinhole.bf = o.focal * o.baseline;
  if (o.distortion > 0) {
    Random random(hash_seed(static_cast<uint64_t>(o.seed), kLens));
    const double s = o.distortion;
    camera.distortion = Distortion::brown_conrady;
    camera.coefficients = {-0.25 * s * random.uniform(0.93, 1.07), 0.08 * s * random.uniform(0.93, 1.07),
                           0.0008 * s * random.uniform(-1, 1), 0.0008 * s * random.uniform(-1, 1), 0};
  }
  return camera;
}

synth::World make_world(const SynthOptions& options) {
  const uint64_t seed = static_cast<uint64_t>(options.seed);
  if (options.world == "corridor") return synth::make_corridor(seed);
  if (options.world == "desk") return synth::make_desk(seed);
  if (options.world == "street") return synth::make_street(seed, options.way);
  if (options.world == "twins") return synth::make_twins(seed);
  if (options.world == "posters") return synth::make_posters(seed);
  return synth::make_room(seed);
}

synth::Traffic traffic_of(const std::string& world) {
  if (world == "room") return synth::Traffic::people_around;
  if (world == "desk") return synth::Traffic::hands;
  return world == "street" ? synth::Traffic::cars : synth::Traffic::people_along;
}

}  // namespace

Result<Synth> Synth::create(const SynthOptions& given) {
  SynthOptions options = given;
  const auto sensor = check(options);
  if (!sensor) return tl::unexpected(sensor.error());
  synth::World world = make_world(options);
  if (options.light > 0) {
    const uint64_t seed = static_cast<uint64_t>(options.seed), light = static_cast<uint64_t>(options.light);
    synth::relight(world.scene, world.path, hash_seed(seed, kLight, light));
  }
  if (options.fps <= 0) options.fps = world.fps;
  if (options.frames <= 0) options.frames = static_cast<int>(std::lround(world.frames * options.fps / world.fps));
  if (options.focal <= 0) options.focal = 0.625 * std::hypot(options.width, options.height);
  if (options.baseline <= 0) {
    options.baseline = *sensor == Sensor::rgbd ? world.depth_sensor.baseline : world.baseline;
  }
  const Camera camera = make_camera(options, *sensor);
  auto renderer = synth::Renderer::create(camera);
  if (!renderer) {
    return fail(renderer.error().message + "; take a synth.distortion below " + std::to_string(options.distortion) +
                " or a longer synth.focal");
  }
  std::optional<synth::MovingThings> moving;
  if (options.moving > 0) {
    const uint64_t seed = hash_seed(static_cast<uint64_t>(options.seed), kMoving);
    moving.emplace(world.scene, traffic_of(options.world), options.moving, seed);
  }
  return Synth(std::unique_ptr<State>(
      new State{options, *sensor, camera, std::move(world), std::move(*renderer), std::move(moving), {}, {}, {}}));
}

Synth::Synth(std::unique_ptr<State> state) : state_(std::move(state)) {}
Synth::Synth(Synth&&) noexcept = default;
Synth& Synth::operator=(Synth&&) noexcept = default;
Synth::~Synth() = default;

const SynthOptions& Synth::options() const { return state_->options; }
Sensor Synth::sensor() const { return state_->sensor; }
double Synth::depth_units() const { return state_->world.depth_sensor.units; }
int Synth::frames() const { return state_->options.frames; }
const Camera& Synth::camera() const { return state_->camera; }
SE3 Synth::T_wc(int i) const { return state_->world.path.at(to_seconds(stamp(i))).T_wc(); }
Timestamp Synth::stamp(int i) const { return 1000 * std::llround(1e6 * i / state_->options.fps); }

namespace {

void brighten(ImageF& tone, double gain, double offset) {
  if (gain == 1 && offset == 0) return;
  for (int y = 0; y < tone.height(); ++y) {
    float* const row = tone.row(y);
    for (int x = 0; x < tone.width(); ++x) row[x] = static_cast<float>(gain) * row[x] + static_cast<float>(offset);
  }
}

// In the left one.
SE3 right_camera(const SynthOptions& o) {
  constexpr double kRadians = std::numbers::pi / 180;
  const Eigen::Matrix3d turn = so3_exp(kRadians * Eigen::Vector3d(-o.right_pitch, o.right_yaw, o.right_roll));
  return SE3(turn, {o.baseline, 0, 0});
}

}  // namespace

void Synth::State::take(double seconds, const SE3& T_camera, Stage noise_stage, int frame, ImageU8& image) {
  const auto pose = [&](double t) { return world.path.at(t).T_wc() * T_camera; };
  const SE3 T_wc = pose(seconds);
  if (moving) moving->place(world.path, seconds, world.scene);
  renderer.render(world.scene, T_wc, tone, depth);
  if (options.blur > 0) {
    const double half = 0.0005 * options.blur;
    const SE3 T_cw = T_wc.inverse();
    synth::blur_motion(renderer, depth, T_cw * pose(seconds - half), T_cw * pose(seconds + half), tone, scratch);
  }
  if (noise_stage == kRightNoise) brighten(tone, options.right_gain, options.right_offset);
  const uint64_t seed = static_cast<uint64_t>(options.seed);
  const double gain =
      options.exposure > 0 ? synth::exposure_gain(options.exposure, hash_seed(seed, kExposure), seconds) : 1;
  synth::develop(tone, gain, options.noise, hash_seed(seed, noise_stage, static_cast<uint64_t>(frame)), image);
}

void Synth::render(int i, ImageU8& left, ImageU8* right, ImageF* depth) {
  State& s = *state_;
  const double seconds = to_seconds(stamp(i));
  if (right) s.take(seconds, right_camera(s.options), kRightNoise, i, *right);
  s.take(seconds, SE3(), kNoise, i, left);
  if (!depth) return;
  depth->resize(s.camera.width, s.camera.height);
  for (int y = 0; y < s.camera.height; ++y) std::copy_n(s.depth.row(y), s.camera.width, depth->row(y));
  if (s.options.depth_noise > 0) {
    const uint64_t seed = hash_seed(static_cast<uint64_t>(s.options.seed), kDepthNoise, static_cast<uint64_t>(i));
    const synth::DepthSensor& sensor = s.world.depth_sensor;
    synth::disturb_depth(s.renderer, s.options.depth_noise, sensor.reach, sensor.units, seed, *depth, s.scratch);
  }
}

}  // namespace covis
