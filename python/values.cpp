// SPDX-License-Identifier: Apache-2.0
// The plain values of the public interface in Python: enums, poses, cameras, results, events and settings.
#include <pybind11/stl.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <utility>

#include "arrays.h"
#include "covis/api/convert.h"

namespace covis::python {
namespace {

std::string text(const Pose& p) {
  char line[160];
  std::snprintf(line, sizeof line, "Pose(x=%.4f, y=%.4f, z=%.4f, qx=%.5f, qy=%.5f, qz=%.5f, qw=%.5f)", p.x, p.y, p.z,
                p.qx, p.qy, p.qz, p.qw);
  return line;
}

// The matrix may be as inexact as a rotation in a file of trajectories (io/trajectory.h).
Pose pose_of_matrix(const py::array_t<double, py::array::c_style | py::array::forcecast>& m) {
  if (m.ndim() != 2 || m.shape(0) != 4 || m.shape(1) != 4) throw py::value_error("matrix: a shape (4, 4) is wanted");
  const Eigen::Matrix4d T = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(m.data());
  if (!T.allFinite()) throw py::value_error("matrix: finite numbers are wanted");
  if ((T.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() > 1e-9)
    throw py::value_error("matrix: a last row of 0, 0, 0, 1 is wanted");
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-2 || R.determinant() < 0)
    throw py::value_error(
        "matrix: a rotation is wanted in the first three rows and columns: orthonormal, determinant 1");
  return to_pose(SE3(R, T.topRightCorner<3, 1>()).normalized());
}

py::object to_array(const std::optional<PoseCovariance>& covariance) {
  if (!covariance) return py::none();
  return py::array_t<double>({6, 6}, covariance->data());
}

CameraParameters make_camera(int width, int height, double fx, double fy, double cx, double cy, double baseline,
                             LensType lens, const std::vector<double>& distortion, double depth_sigma_a,
                             double depth_sigma_b, double readout, double depth_fx, double depth_cx, double depth_cy,
                             double depth_x, double depth_y) {
  CameraParameters c;
  c.width = width;
  c.height = height;
  c.fx = fx;
  c.fy = fy;
  c.cx = cx;
  c.cy = cy;
  c.baseline = baseline;
  c.lens = lens;
  c.depth_sigma_a = depth_sigma_a;
  c.depth_sigma_b = depth_sigma_b;
  c.readout = readout;
  c.depth_fx = depth_fx;
  c.depth_cx = depth_cx;
  c.depth_cy = depth_cy;
  c.depth_x = depth_x;
  c.depth_y = depth_y;
  if (distortion.size() > std::size(c.distortion)) throw py::value_error("distortion: five figures at most");
  std::copy(distortion.begin(), distortion.end(), std::begin(c.distortion));
  return c;
}

void bind_choices(py::module_& m) {
  py::enum_<SensorType>(m, "Sensor", "The images of a camera.")
      .value("monocular", SensorType::monocular, "One grey image.")
      .value("stereo", SensorType::stereo, "Two grey images, of a left and a right camera.")
      .value("rgbd", SensorType::rgbd, "A grey image and its depth.");
  py::enum_<LensType>(m, "Lens", "How a lens bends, and the figures of Camera.distortion.")
      .value("none", LensType::none, "Not at all.")
      .value("brown_conrady", LensType::brown_conrady, "k1 k2 p1 p2 k3.")
      .value("kannala_brandt", LensType::kannala_brandt, "A fisheye: k1 k2 k3 k4.");
  py::enum_<Timing>(m, "Timing", "When the work of mapping shows.")
      .value("realtime", Timing::realtime, "As soon as it is ready, for a live camera.")
      .value("deterministic", Timing::deterministic,
             "For recordings: results depend on the input and the settings alone.");
  py::enum_<Mode>(m, "Mode", "Is the map changed?")
      .value("mapping", Mode::mapping, "It grows.")
      .value("localisation", Mode::localisation, "It is not changed: no key frames, no points.");
  py::enum_<ColourOrder>(m, "ColourOrder", "The order of a pixel's three bytes.")
      .value("rgb", ColourOrder::rgb, "Red, green, blue.")
      .value("bgr", ColourOrder::bgr, "Blue, green, red, as OpenCV has them.");
  py::enum_<SettingType>(m, "SettingType", "The form of a setting's value.")
      .value("whole_number", SettingType::whole_number, "For example 2000.")
      .value("number", SettingType::number, "For example 1.2.")
      .value("boolean", SettingType::boolean, "true or false.")
      .value("text", SettingType::text, "Any text.");
  py::enum_<LogLevel>(m, "LogLevel", "How much a message matters.")
      .value("debug", LogLevel::debug)
      .value("info", LogLevel::info)
      .value("warning", LogLevel::warning)
      .value("error", LogLevel::error);
}

void bind_states(py::module_& m) {
  py::enum_<TrackingState> state(m, "TrackingState", "What tracking knows of a frame.");
  for (const auto& [s, doc] : {std::pair(TrackingState::not_initialised, "There is no map yet."),
                               std::pair(TrackingState::tracking, "The frame has a pose."),
                               std::pair(TrackingState::lost, "The frame's place in the map is not known.")})
    state.value(name(s), s, doc);
  py::enum_<NoPoseReason> reason(m, "NoPoseReason", "Why a frame has no pose; describe(reason) says it in words.");
  reason.value(name(NoPoseReason::none), NoPoseReason::none, "It has one.");
  for (int k = 1; k <= static_cast<int>(NoPoseReason::no_key_frame_matches); ++k) {
    const auto r = static_cast<NoPoseReason>(k);
    reason.value(name(r), r, describe(r));
  }
  using Kind = Event::Kind;
  py::enum_<Kind> kind(m, "EventKind", "Things that happen.");
  for (const auto& [k, doc] :
       {std::pair(Kind::key_frame_made, "Mapping made a key frame."),
        std::pair(Kind::loop_closed, "A place was seen again, and the map was corrected."),
        std::pair(Kind::submaps_joined, "A place of another submap was seen; both are one now."),
        std::pair(Kind::submap_begun, "The first map, or one beside those there are."),
        std::pair(Kind::submap_discarded, "A monocular submap that was lost in its first moments."),
        std::pair(Kind::lost, "The frame has no pose, and the one before had one."),
        std::pair(Kind::found, "The camera was lost, and its place in the map is known again."),
        std::pair(Kind::sensor_doubted, "Images, a pair or depth are not to be believed; a message says why.")})
    kind.value(name(k), k, doc);
}

void bind_cameras(py::module_& m) {
  py::class_<Pose>(m, "Pose", "T_wc, camera to world: metres and a unit quaternion.")
      .def(py::init([](double x, double y, double z, double qx, double qy, double qz, double qw) {
             return Pose{x, y, z, qx, qy, qz, qw};
           }),
           py::arg("x") = 0., py::arg("y") = 0., py::arg("z") = 0., py::arg("qx") = 0., py::arg("qy") = 0.,
           py::arg("qz") = 0., py::arg("qw") = 1.)
      .def_static("from_matrix", &pose_of_matrix, py::arg("matrix"),
                  "The pose of a matrix: (4, 4), float64, camera to world, a rotation and metres.")
      .def_property_readonly("matrix", &matrix_of, "(4, 4), float64: camera to world, a rotation and metres.")
      .def_readwrite("x", &Pose::x, "Metres.")
      .def_readwrite("y", &Pose::y, "Metres.")
      .def_readwrite("z", &Pose::z, "Metres.")
      .def_readwrite("qx", &Pose::qx, "First of the unit quaternion x y z w.")
      .def_readwrite("qy", &Pose::qy, "Second of the unit quaternion x y z w.")
      .def_readwrite("qz", &Pose::qz, "Third of the unit quaternion x y z w.")
      .def_readwrite("qw", &Pose::qw, "Fourth, the real one, of the unit quaternion x y z w.")
      .def("__repr__", &text);
  py::class_<CameraParameters>(m, "Camera", "A pinhole camera and its lens.")
      .def(py::init(&make_camera), py::arg("width"), py::arg("height"), py::arg("fx"), py::arg("fy"), py::arg("cx"),
           py::arg("cy"), py::kw_only(), py::arg("baseline") = 0., py::arg("lens") = LensType::none,
           py::arg("distortion") = std::vector<double>(), py::arg("depth_sigma_a") = 0., py::arg("depth_sigma_b") = 0.,
           py::arg("readout") = 0., py::arg("depth_fx") = 0., py::arg("depth_cx") = 0., py::arg("depth_cy") = 0.,
           py::arg("depth_x") = 0., py::arg("depth_y") = 0.)
      .def_readonly("width", &CameraParameters::width, "Pixels.")
      .def_readonly("height", &CameraParameters::height, "Pixels.")
      .def_readonly("fx", &CameraParameters::fx, "Focal length along x, pixels.")
      .def_readonly("fy", &CameraParameters::fy, "Focal length along y, pixels.")
      .def_readonly("cx", &CameraParameters::cx, "Principal point, pixels.")
      .def_readonly("cy", &CameraParameters::cy, "Principal point, pixels.")
      .def_readonly("baseline", &CameraParameters::baseline,
                    "Metres between the cameras of a rectified stereo pair; else 0.")
      .def_readonly("lens", &CameraParameters::lens, "The Lens whose figures `distortion` has.")
      .def_property_readonly(
          "distortion",
          [](const CameraParameters& c) {
            return std::vector<double>(std::begin(c.distortion), std::end(c.distortion));
          },
          "List of 5: brown_conrady k1 k2 p1 p2 k3; kannala_brandt k1 k2 k3 k4.")
      .def_readonly("depth_sigma_a", &CameraParameters::depth_sigma_a,
                    "Noise of a depth z: sigma = a + b z^2; a in metres. Both 0: estimated from the map.")
      .def_readonly("depth_sigma_b", &CameraParameters::depth_sigma_b,
                    "Noise of a depth z: sigma = a + b z^2; b in 1 / metres. Both 0: estimated from the map.")
      .def_readonly("readout", &CameraParameters::readout,
                    "Rolling shutter: seconds from the exposure of the first row to that of the last, from -0.2 to "
                    "0.2; negative where the last row comes first. 0: all rows at once, or not known, and a run may "
                    "find one.")
      .def_readonly("depth_fx", &CameraParameters::depth_fx,
                    "Focal length, pixels, of the camera of depth images that are not registered to the others. 0: "
                    "they are registered, or a run may find how they are to be.")
      .def_readonly("depth_cx", &CameraParameters::depth_cx, "Its principal point, pixels. 0: as cx.")
      .def_readonly("depth_cy", &CameraParameters::depth_cy, "Its principal point, pixels. 0: as cy.")
      .def_readonly("depth_x", &CameraParameters::depth_x, "Where it is: metres to the right of the other camera.")
      .def_readonly("depth_y", &CameraParameters::depth_y, "Where it is: metres below the other camera.");
  py::class_<RightCamera>(m, "RightCamera", "The right camera of a stereo pair that is not rectified.")
      .def(py::init([](const CameraParameters& camera, const Pose& pose) {
             return RightCamera{camera, pose};
           }),
           py::arg("camera"), py::arg("pose"))
      .def_readonly("camera", &RightCamera::camera,
                    "Its Camera, without baseline; readout: 0, or that of the left one.")
      .def_readonly("pose", &RightCamera::pose, "The right camera's Pose in the left one's coordinates, metres.");
}

void bind_results(py::module_& m) {
  py::class_<FrameResult>(m, "FrameResult", "What tracking found for one frame.")
      .def_readonly("state", &FrameResult::state, "A TrackingState.")
      .def_property_readonly("tracked", &FrameResult::tracked, "The frame has a pose.")
      .def_readonly("reason", &FrameResult::reason, "The NoPoseReason; none where there is a pose.")
      .def_property_readonly(
          "pose", [](const FrameResult& r) { return r.tracked() ? std::optional(r.pose) : std::nullopt; },
          "The camera's Pose in its submap's world; None without one.")
      .def_readonly("submap", &FrameResult::submap, "Id of the submap whose world the pose is in.")
      .def_readonly("tentative", &FrameResult::tentative,
                    "The camera was found far from its last place, or found again by few matches, less than a second "
                    "ago, or depth is not to be believed: the pose may be withdrawn.")
      .def_readonly("dead_reckoned", &FrameResult::dead_reckoned,
                    "Localisation only: too few points of the map are seen, and the frame's own depth carried the "
                    "pose on.")
      .def_readonly("retracted_from", &FrameResult::retracted_from,
                    "Stamp, nanoseconds: frames from it on have lost their poses, for the place proved wrong; or None.")
      .def_readonly("inliers", &FrameResult::inliers, "Number of map points that agree with the pose.")
      .def_readonly("key_frame", &FrameResult::key_frame, "A key frame was asked for.")
      .def_property_readonly(
          "covariance", [](const FrameResult& r) { return to_array(r.covariance); },
          "(6, 6), float64: of x, y, z (metres) and turns about the world's axes (radians); None where it is not "
          "known.")
      .def("__repr__", [](const FrameResult& r) {
        return r.tracked() ? "FrameResult(tracking, " + text(r.pose) + ")"
                           : std::string("FrameResult(") + name(r.state) + ": " + describe(r.reason) + ")";
      });
  py::class_<Location>(m, "Location", "The place of one image in the map.")
      .def_readonly("pose", &Location::pose, "The camera's Pose in the submap's world.")
      .def_readonly("submap", &Location::submap, "Id of the submap whose world the pose is in.")
      .def_readonly("inliers", &Location::inliers, "Number of map points that agree with the pose.")
      .def_property_readonly(
          "covariance", [](const Location& l) { return to_array(l.covariance); },
          "(6, 6), float64: as FrameResult.covariance.");
  py::class_<Event>(m, "Event", "Something that happened while frames were tracked.")
      .def_readonly("kind", &Event::kind, "The EventKind.")
      .def_readonly("stamp", &Event::stamp, "Stamp of the frame or key frame it happened with, nanoseconds.")
      .def_readonly("submap", &Event::submap,
                    "Id of the submap; of two that were joined the one that remains; lost: where the camera was.")
      .def_readonly("ended", &Event::ended, "submaps_joined: id of the submap that is none any more; else None.")
      .def_readonly("key_frame", &Event::key_frame,
                    "key_frame_made, loop_closed, submaps_joined: id of the key frame; else None.")
      .def_readonly("place", &Event::place,
                    "loop_closed, submaps_joined: id of the key frame of the place that was seen again; else None.")
      .def_readonly("reason", &Event::reason, "lost: the NoPoseReason; else none.");
  py::class_<Setting>(m, "Setting", "A setting of the system: give it as settings={name: value}.")
      .def_readonly("name", &Setting::name, "For example orb.features.")
      .def_readonly("type", &Setting::type, "The SettingType of its value.")
      .def_readonly("value", &Setting::value, "As text.")
      .def_readonly("min", &Setting::min,
                    "The least value allowed, of numbers, but for one that the description names.")
      .def_readonly("max", &Setting::max, "The greatest value allowed, of numbers.")
      .def_readonly("description", &Setting::description, "Its effect, with its unit.");
}

}  // namespace

void bind_values(py::module_& m) {
  m.attr("NO_COLOUR") = py::make_tuple(kNoColour[0], kNoColour[1], kNoColour[2]);
  bind_choices(m);
  bind_states(m);
  bind_cameras(m);
  bind_results(m);
}

}  // namespace covis::python
