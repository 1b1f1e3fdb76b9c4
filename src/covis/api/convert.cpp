// SPDX-License-Identifier: Apache-2.0
#include "covis/api/convert.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <unordered_map>

#include "covis/geometry/camera_check.h"

namespace covis {
namespace {

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

LensType to_lens(Distortion distortion) {
  switch (distortion) {
    case Distortion::none:
      return LensType::none;
    case Distortion::brown_conrady:
      return LensType::brown_conrady;
    case Distortion::kannala_brandt:
      return LensType::kannala_brandt;
  }
  return LensType::none;
}

// The problem of an impossible lens or size, of any camera.
std::optional<std::string> lens_problem(const CameraParameters& c) {
  if (c.width < 64 || c.height < 64) return "width and height must be at least 64 pixels";
  if (!(c.fx > 0) || !(c.fy > 0) || !std::isfinite(c.fx) || !std::isfinite(c.fy)) return "fx and fy must be positive";
  if (!(c.cx > 0 && c.cx < c.width && c.cy > 0 && c.cy < c.height)) return "cx and cy must be in the image";
  for (const double k : c.distortion) {
    if (!std::isfinite(k)) return "distortion must be finite";
    if (k != 0 && c.lens == LensType::none) return "distortion has figures, and lens is none";
  }
  return std::nullopt;
}

DepthRegistration registration_in(const CameraParameters& c) {
  const double cx = c.depth_cx == 0 ? c.cx : c.depth_cx, cy = c.depth_cy == 0 ? c.cy : c.depth_cy;
  return registration_of({c.depth_fx, cx, cy, c.depth_x, c.depth_y}, c.fx, c.cx, c.cy);
}

void set_registration(CameraParameters& parameters, const Pinhole& p) {
  const DepthCamera depth = p.registration.any() ? depth_camera_of(p.registration, p.fx, p.cx, p.cy) : DepthCamera();
  parameters.depth_fx = depth.fx;
  parameters.depth_cx = depth.cx;
  parameters.depth_cy = depth.cy;
  parameters.depth_x = depth.x;
  parameters.depth_y = depth.y;
}

std::optional<std::string> depth_camera_problem(const CameraParameters& c) {
  if (c.depth_fx == 0) {
    if (c.depth_cx == 0 && c.depth_cy == 0 && c.depth_x == 0 && c.depth_y == 0) return std::nullopt;
    return "depth_cx, depth_cy, depth_x and depth_y are of use with depth_fx only, which is 0";
  }
  if (registration_in(c).valid()) return std::nullopt;
  return "depth_fx must be from 0.1 to 10 times fx, and depth_cx, depth_cy, depth_x and depth_y finite";
}

std::optional<std::string> right_problem(const SlamOptions& options) {
  const RightCamera& right = *options.right;
  if (options.sensor != SensorType::stereo) return "right: only a stereo pair has a right camera";
  if (options.camera.baseline != 0)
    return "camera: baseline is that of a rectified pair; with `right` its pose says it";
  if (right.camera.readout != 0 && right.camera.readout != options.camera.readout)
    return "right: readout must be 0 or that of the left camera";
  if (const auto problem = lens_problem(right.camera)) return "right: " + *problem;
  if (const auto problem = problem_of(to_camera(right.camera, SensorType::monocular))) return "right: " + *problem;
  const Pose& p = right.pose;
  const double norm = std::hypot(std::hypot(p.qx, p.qy), std::hypot(p.qz, p.qw));
  if (!std::isfinite(p.x + p.y + p.z) || !(std::abs(norm - 1) < 1e-3))
    return "right: pose must be finite, with a unit quaternion";
  return std::nullopt;
}

// The covariance of the pose T_wc from the information of xi in exp(xi) T_cw, to first order: the centre moves by
// -R_wc rho, and the orientation turns by -R_wc phi about the world's axes.
std::optional<PoseCovariance> covariance_of(const Matrix6d& information, const SE3& T_cw) {
  const Eigen::LDLT<Matrix6d> factors(information);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0)) return std::nullopt;
  Matrix6d to_world = Matrix6d::Zero();
  to_world.topLeftCorner<3, 3>() = to_world.bottomRightCorner<3, 3>() = T_cw.R().transpose();
  const Matrix6d covariance = to_world * factors.solve(Matrix6d::Identity()) * to_world.transpose();
  if (!covariance.allFinite()) return std::nullopt;
  PoseCovariance result;
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(result.data()) = 0.5 * (covariance + covariance.transpose());
  return result;
}

MapSnapshot to_public(const Snapshot& from) {
  MapSnapshot to;
  for (const SubmapSummary& s : from.submaps)
    to.submaps.push_back({static_cast<int>(s.id), s.loaded, s.frames, s.key_frames, s.points});
  std::unordered_map<KeyFrameId, int64_t> index;
  for (const Snapshot::KeyFrame& k : from.key_frames) index.emplace(k.id, static_cast<int64_t>(index.size()));
  to.key_frames.reserve(from.key_frames.size());
  for (const Snapshot::KeyFrame& k : from.key_frames) {
    const auto parent = index.find(k.parent);
    to.key_frames.push_back({k.serial, k.frame, k.stamp, to_pose(k.T_wc), static_cast<int>(k.submap),
                             parent == index.end() ? -1 : parent->second, static_cast<int>(k.camera)});
  }
  to.cameras.resize(1);  // the one in use: PublicSnapshots
  for (const RefinedCamera& camera : from.other_cameras)
    to.cameras.push_back(in_use(to_parameters(camera.given), camera.pinhole));
  to.points.reserve(from.points.size());
  for (const auto& [id, p, submap, colour] : from.points)
    to.points.push_back({id_number(id), p.x(), p.y(), p.z(), static_cast<int>(submap), colour});
  to.edges = from.edges;
  to.observations = from.observations;
  to.trajectory = to_trajectory(from.trajectory);
  return to;
}

SettingType type_of(const Field& field) {
  constexpr SettingType kTypes[] = {SettingType::whole_number, SettingType::number, SettingType::boolean,
                                    SettingType::text};
  static_assert(std::variant_size_v<decltype(field.value)> == std::size(kTypes));
  return kTypes[field.value.index()];
}

}  // namespace

const char* member_of_options(std::string_view setting) {
  if (setting == "system.realtime") return "SlamOptions::timing";
  if (setting == "system.localize") return "SlamOptions::mode";
  return nullptr;
}

Pose to_pose(const SE3& T) {
  const Eigen::Quaterniond q = T.q();
  return {T.t().x(), T.t().y(), T.t().z(), q.x(), q.y(), q.z(), q.w()};
}

SE3 to_se3(const Pose& p) {
  return SE3(Eigen::Quaterniond(p.qw, p.qx, p.qy, p.qz).normalized().toRotationMatrix(), {p.x, p.y, p.z});
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

std::optional<std::string> camera_problem(const SlamOptions& options) {
  const CameraParameters& c = options.camera;
  if (const auto problem = lens_problem(c)) return "camera: " + *problem;
  if (!(c.baseline >= 0 && std::isfinite(c.baseline))) return "camera: baseline must be finite and not negative";
  if (!DepthNoise{c.depth_sigma_a, c.depth_sigma_b}.valid())
    return "camera: depth_sigma_a and depth_sigma_b must be finite and not negative";
  if (const auto problem = depth_camera_problem(c)) return "camera: " + *problem;
  if (const auto problem = problem_of(to_camera(c, options.sensor))) return "camera: " + *problem;
  if (options.right) return right_problem(options);
  if (options.sensor != SensorType::stereo) return std::nullopt;
  if (!(c.baseline > 0)) return "camera: a rectified stereo pair needs a positive baseline in metres";
  if (c.lens != LensType::none) return "camera: a stereo pair with a lens must be rectified: give the `right` camera";
  return std::nullopt;
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
  camera.pinhole.row_time = parameters.readout / parameters.height;
  if (sensor == SensorType::rgbd && parameters.depth_fx != 0) camera.pinhole.registration = registration_in(parameters);
  camera.distortion = to_distortion(parameters.lens);
  std::copy(std::begin(parameters.distortion), std::end(parameters.distortion), camera.coefficients.begin());
  return camera;
}

CameraParameters to_parameters(const Camera& camera) {
  const Pinhole& p = camera.pinhole;
  CameraParameters made{.width = camera.width,
                        .height = camera.height,
                        .fx = p.fx,
                        .fy = p.fy,
                        .cx = p.cx,
                        .cy = p.cy,
                        .baseline = p.baseline(),
                        .depth_sigma_a = p.depth_noise.a,
                        .depth_sigma_b = p.depth_noise.b,
                        .lens = to_lens(camera.distortion),
                        .readout = p.row_time * camera.height};
  std::copy(camera.coefficients.begin(), camera.coefficients.end(), std::begin(made.distortion));
  set_registration(made, p);
  return made;
}

CameraParameters in_use(CameraParameters given, const Pinhole& now) {
  given.fx = now.fx;
  given.fy = now.fy;
  if (now.residual.any()) {  // it is looked for where none was given
    given.lens = LensType::brown_conrady;
    given.distortion[0] = now.residual.k1;
    given.distortion[1] = now.residual.k2;
  }
  given.depth_sigma_a = now.depth_noise.a;
  given.depth_sigma_b = now.depth_noise.b;
  given.readout = now.row_time * given.height;
  if (given.depth_fx != 0 || now.bf > 0) set_registration(given, now);  // a camera alone has none, its map may
  return given;
}

FrameResult to_result(const FrameReport& report) {
  const TrackResult& track = report.track;
  FrameResult result;
  result.state = track.state;
  result.reason = track.reason;
  result.key_frame = track.key_frame;
  result.retracted_from = report.retracted_from;
  if (!result.tracked()) return result;
  result.inliers = track.inliers;
  result.pose = to_pose(track.T_cw.inverse());
  result.submap = static_cast<int>(track.submap);
  result.tentative = track.tentative;
  result.dead_reckoned = track.method == TrackMethod::dead_reckoned;
  result.covariance = covariance_of(track.information, track.T_cw);
  return result;
}

Location to_location(const LocatedImage& located) {
  return {to_pose(located.T_wc), static_cast<int>(located.submap), located.inliers,
          covariance_of(located.information, located.T_wc.inverse())};
}

std::vector<TrajectoryPose> to_trajectory(const std::vector<PoseOfFrame>& poses) {
  std::vector<TrajectoryPose> results;
  results.reserve(poses.size());
  for (const PoseOfFrame& pose : poses)
    results.push_back({pose.stamp, to_pose(pose.T_wc), static_cast<int>(pose.submap)});
  return results;
}

std::vector<Setting> to_settings(const Fields& fields) {
  std::vector<Setting> settings;
  for (const Field& field : fields) {
    if (member_of_options(field.name)) continue;
    settings.push_back({field.name, type_of(field), field_text(field), field.min, field.max, field.doc});
  }
  return settings;
}

std::shared_ptr<const MapSnapshot> PublicSnapshots::get(const std::function<const System&()>& current,
                                                        const CameraParameters& given) {
  const std::lock_guard lock(mutex_);
  const std::shared_ptr<const Snapshot> source = current().snapshot();
  if (source != source_) {
    auto made = std::make_shared<MapSnapshot>(to_public(*source));
    made->camera = made->cameras.front() = in_use(given, source->camera);
    made->revision = latest_ ? latest_->revision + 1 : 1;
    source_ = source;
    latest_ = std::move(made);
  }
  return latest_;
}

}  // namespace covis
