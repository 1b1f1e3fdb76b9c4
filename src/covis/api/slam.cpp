// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "covis/core/fields.h"
#include "covis/covis.h"
#include "covis/slam/system.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {
namespace {

using Failure = tl::unexpected<std::string>;

ImageView<const uint8_t> view(const GreyImage& image) { return {image.data, image.width, image.height, image.stride}; }

Pose to_pose(const SE3& T) {
  const Eigen::Quaterniond q = T.q();
  return {T.t().x(), T.t().y(), T.t().z(), q.x(), q.y(), q.z(), q.w()};
}

template <class Poses>
std::vector<StampedPoseResult> to_results(const Poses& poses) {
  std::vector<StampedPoseResult> results;
  results.reserve(poses.size());
  for (const PoseOfFrame& pose : poses)
    results.push_back({pose.stamp, to_pose(pose.T_wc), static_cast<int>(pose.submap)});
  return results;
}

TrackingState to_state(TrackState state) {
  switch (state) {
    case TrackState::not_initialised:
      return TrackingState::not_initialised;
    case TrackState::tracking:
      return TrackingState::tracking;
    case TrackState::lost:
      return TrackingState::lost;
  }
  return TrackingState::lost;
}

Sensor to_sensor(SensorType sensor) {
  switch (sensor) {
    case SensorType::monocular:
      return Sensor::monocular;
    case SensorType::stereo:
      return Sensor::stereo;
    case SensorType::rgbd:
      return Sensor::rgbd;
  }
  return Sensor::monocular;
}

Distortion to_distortion(LensType lens) {
  switch (lens) {
    case LensType::none:
      return Distortion::none;
    case LensType::brown_conrady:
      return Distortion::brown_conrady;
    case LensType::kannala_brandt:
      return Distortion::kannala_brandt;
  }
  return Distortion::none;
}

Camera to_camera(const CameraParameters& parameters, SensorType sensor) {
  Camera camera;
  camera.width = parameters.width;
  camera.height = parameters.height;
  double baseline = sensor == SensorType::monocular ? 0 : parameters.baseline;
  if (sensor == SensorType::rgbd && baseline == 0) baseline = kVirtualBaseline;
  camera.pinhole = {parameters.fx,
                    parameters.fy,
                    parameters.cx,
                    parameters.cy,
                    parameters.fx * baseline,
                    {parameters.depth_sigma_a, parameters.depth_sigma_b}};
  camera.distortion = to_distortion(parameters.lens);
  std::copy(std::begin(parameters.distortion), std::end(parameters.distortion), camera.coefficients.begin());
  return camera;
}

// Returns the problem of an impossible camera, nothing for a possible one.
std::optional<std::string> check(const CameraParameters& c, SensorType sensor) {
  if (c.width < 64 || c.height < 64) return "camera: width and height must be at least 64 pixels";
  if (!(c.fx > 0) || !(c.fy > 0) || !std::isfinite(c.fx) || !std::isfinite(c.fy))
    return "camera: fx and fy must be positive";
  if (!std::isfinite(c.cx) || !std::isfinite(c.cy)) return "camera: cx and cy must be finite";
  for (const double k : c.distortion) {
    if (!std::isfinite(k)) return "camera: distortion must be finite";
  }
  if (sensor == SensorType::stereo && !(c.baseline > 0)) return "camera: stereo needs a positive baseline in metres";
  if (!(c.baseline >= 0 && std::isfinite(c.baseline))) return "camera: baseline must be finite and not negative";
  if (!DepthNoise{c.depth_sigma_a, c.depth_sigma_b}.valid())
    return "camera: depth_sigma_a and depth_sigma_b must be finite and not negative";
  if (sensor == SensorType::stereo && c.lens != LensType::none)
    return "camera: stereo pairs must be rectified (lens none)";
  return std::nullopt;
}

}  // namespace

struct Slam::Impl {
  Impl(const CameraParameters& parameters, const Camera& c, const SystemOptions& options,
       std::shared_ptr<const Vocabulary> vocabulary)
      : given(parameters), camera(c), sensor(options.sensor), system(c, options, std::move(vocabulary)) {}

  template <class Image>
  std::optional<std::string> check_image(const Image& image, const char* which) const {
    if (image.data && image.width == camera.width && image.height == camera.height) {
      if (image.stride >= image.width) return {};
      return std::string(which) + ": the stride, " + std::to_string(image.stride) + ", is less than the width";
    }
    return std::string(which) + ": the image is empty or is " + std::to_string(image.width) + "x" +
           std::to_string(image.height) + "; the camera is " + std::to_string(camera.width) + "x" +
           std::to_string(camera.height);
  }

  // Checks the images of a call and hands them to the system. Null: the sensor has no such image.
  tl::expected<System::Input, std::string> input(Sensor called, const GreyImage& image, const GreyImage* right,
                                                 const DepthImage* depth) const {
    if (called != sensor) return Failure("this system was created for another sensor");
    if (const auto problem = check_image(image, right ? "left" : "image")) return Failure(*problem);
    System::Input input;
    input.frame = next_frame;
    input.image = view(image);
    if (right) {
      if (const auto problem = check_image(*right, "right")) return Failure(*problem);
      input.right = view(*right);
    }
    if (depth) {
      if (const auto problem = check_image(*depth, "depth")) return Failure(*problem);
      input.depth = {depth->data, depth->width, depth->height, depth->stride};
    }
    return input;
  }

  tl::expected<FrameResult, std::string> track(int64_t stamp, tl::expected<System::Input, std::string> input) {
    if (!input) return Failure(input.error());
    if (stamp <= last_stamp) return Failure("stamps must rise from frame to frame");
    input->stamp = last_stamp = stamp;
    ++next_frame;
    const TrackResult track = system.process(*input).track;
    FrameResult result;
    result.tracked = track.state == TrackState::tracking;
    result.state = to_state(track.state);
    result.reason = track.reason;
    result.inliers = track.inliers;
    result.key_frame = track.key_frame;
    if (result.tracked) {
      result.pose = to_pose(track.T_cw.inverse());
      result.submap = static_cast<int>(track.submap);
      result.tentative = track.tentative;
    }
    return result;
  }

  Located locate(const tl::expected<System::Input, std::string>& input) {
    if (!input) return Failure(input.error());
    const auto found = system.locate(*input);
    if (!found) return std::nullopt;
    return Location{to_pose(found->T_wc), static_cast<int>(found->submap)};
  }

  CameraParameters given;
  Camera camera;
  Sensor sensor;
  System system;
  int64_t next_frame = 0;
  int64_t last_stamp = std::numeric_limits<int64_t>::min();
};

Slam::Slam(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Slam::~Slam() = default;

tl::expected<std::unique_ptr<Slam>, std::string> Slam::create(const CameraParameters& parameters, SensorType sensor,
                                                              const Settings& settings, const std::string& vocabulary) {
  if (const auto problem = check(parameters, sensor)) return Failure(*problem);
  SystemOptions options;
  const Fields known = fields(options);
  for (const auto& [name, value] : settings) {
    if (const auto done = set_field(known, name, value); !done) return Failure(done.error().message);
  }
  if (options.localize) {
    return Failure(
        "system.localize: it needs a saved map to localise in, which can't be loaded here; covis run --map FILE "
        "--localize does");
  }
  options.sensor = to_sensor(sensor);
  std::shared_ptr<const Vocabulary> words;
  if (!vocabulary.empty()) {
    auto loaded = Vocabulary::load(vocabulary);
    if (!loaded) return Failure(loaded.error().message);
    words = std::move(*loaded);
  }
  return std::unique_ptr<Slam>(
      new Slam(std::make_unique<Impl>(parameters, to_camera(parameters, sensor), options, std::move(words))));
}

tl::expected<FrameResult, std::string> Slam::track_monocular(int64_t stamp, const GreyImage& image) {
  return impl_->track(stamp, impl_->input(Sensor::monocular, image, nullptr, nullptr));
}

tl::expected<FrameResult, std::string> Slam::track_stereo(int64_t stamp, const GreyImage& left,
                                                          const GreyImage& right) {
  return impl_->track(stamp, impl_->input(Sensor::stereo, left, &right, nullptr));
}

tl::expected<FrameResult, std::string> Slam::track_rgbd(int64_t stamp, const GreyImage& image,
                                                        const DepthImage& depth) {
  return impl_->track(stamp, impl_->input(Sensor::rgbd, image, nullptr, &depth));
}

Slam::Located Slam::locate_monocular(const GreyImage& image) {
  return impl_->locate(impl_->input(Sensor::monocular, image, nullptr, nullptr));
}

Slam::Located Slam::locate_stereo(const GreyImage& left, const GreyImage& right) {
  return impl_->locate(impl_->input(Sensor::stereo, left, &right, nullptr));
}

Slam::Located Slam::locate_rgbd(const GreyImage& image, const DepthImage& depth) {
  return impl_->locate(impl_->input(Sensor::rgbd, image, nullptr, &depth));
}

void Slam::finish() { impl_->system.finish(); }

std::vector<StampedPoseResult> Slam::trajectory() const { return to_results(impl_->system.snapshot()->trajectory); }

std::vector<StampedPoseResult> Slam::key_frames() const { return to_results(impl_->system.snapshot()->key_frames); }

std::vector<Point> Slam::points() const {
  const auto snapshot = impl_->system.snapshot();
  std::vector<Point> points;
  points.reserve(snapshot->points.size());
  for (const auto& [id, position_w, submap] : snapshot->points)
    points.push_back({position_w.x(), position_w.y(), position_w.z(), static_cast<int>(submap)});
  return points;
}

CameraParameters Slam::camera() const {
  CameraParameters camera = impl_->given;
  const Pinhole now = impl_->system.map().read()->camera();
  camera.fx = now.fx;
  camera.fy = now.fy;
  camera.depth_sigma_a = now.depth_noise.a;
  camera.depth_sigma_b = now.depth_noise.b;
  return camera;
}

const char* name(TrackingState state) {
  switch (state) {
    case TrackingState::not_initialised:
      return "not_initialised";
    case TrackingState::tracking:
      return "tracking";
    case TrackingState::lost:
      return "lost";
  }
  return "";
}

}  // namespace covis
