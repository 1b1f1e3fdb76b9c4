// SPDX-License-Identifier: Apache-2.0
// The Python module covis._covis: include/covis as it is, with NumPy arrays for images and lists of points.
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <cmath>
#include <cstdio>

#include "arrays.h"

namespace covis::python {
namespace {

// The interpreter's lock is released in every call that may take long or write a message: a message waits for it in the
// thread that writes.
using Released = py::call_guard<py::gil_scoped_release>;

std::string text(const Pose& p) {
  char line[160];
  std::snprintf(line, sizeof line, "Pose(x=%.4f, y=%.4f, z=%.4f, qx=%.5f, qy=%.5f, qz=%.5f, qw=%.5f)", p.x, p.y, p.z,
                p.qx, p.qy, p.qz, p.qw);
  return line;
}

Pose pose_of_matrix(const py::array_t<double, py::array::c_style | py::array::forcecast>& m) {
  if (m.ndim() != 2 || m.shape(0) != 4 || m.shape(1) != 4) throw py::value_error("a matrix of 4 x 4 is wanted");
  const auto r = m.unchecked<2>();
  // Shepperd, "Quaternion from rotation matrix", 1978: the greatest of the four is computed first.
  const double trace = r(0, 0) + r(1, 1) + r(2, 2);
  double q[4];  // x y z w
  int at = 3;
  double most = trace;
  for (int i = 0; i < 3; ++i) {
    if (r(i, i) > most) most = r(i, i), at = i;
  }
  if (at == 3) {
    q[3] = 1 + trace;
    q[0] = r(2, 1) - r(1, 2);
    q[1] = r(0, 2) - r(2, 0);
    q[2] = r(1, 0) - r(0, 1);
  } else {
    const int j = (at + 1) % 3, k = (at + 2) % 3;
    q[at] = 1 + r(at, at) - r(j, j) - r(k, k);
    q[j] = r(j, at) + r(at, j);
    q[k] = r(k, at) + r(at, k);
    q[3] = r(k, j) - r(j, k);
  }
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {r(0, 3), r(1, 3), r(2, 3), q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm};
}

py::object to_array(const std::optional<PoseCovariance>& covariance) {
  if (!covariance) return py::none();
  return py::array_t<double>({6, 6}, covariance->data());
}

CameraParameters make_camera(int width, int height, double fx, double fy, double cx, double cy, double baseline,
                             LensType lens, const std::vector<double>& distortion, double depth_sigma_a,
                             double depth_sigma_b) {
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
  if (distortion.size() > std::size(c.distortion)) throw py::value_error("distortion: five figures at most");
  std::copy(distortion.begin(), distortion.end(), std::begin(c.distortion));
  return c;
}

Frame to_frame(int64_t stamp, const py::object& image, const py::object& right, const py::object& depth,
               const py::object& colour, ColourOrder order) {
  Frame frame;
  frame.stamp = stamp;
  if (!image.is_none() || colour.is_none()) frame.image = to_grey(image, "image");
  if (!colour.is_none()) frame.colour = to_colour(colour, order);
  if (!right.is_none()) frame.right = to_grey(right, "right");
  if (!depth.is_none()) frame.depth = to_depth(depth);
  return frame;
}

std::vector<std::pair<std::string, std::string>> to_settings(const py::dict& settings) {
  std::vector<std::pair<std::string, std::string>> list;
  for (const auto& [name, value] : settings) {
    std::string text = py::str(value);
    if (py::isinstance<py::bool_>(value)) text = value.cast<bool>() ? "true" : "false";
    list.emplace_back(py::str(name), text);
  }
  return list;
}

// Ending a system waits for its threads, whose messages may wait for the interpreter's lock.
struct DeleteReleased {
  void operator()(Slam* slam) const {
    const py::gil_scoped_release released;
    delete slam;
  }
};
using SlamHolder = std::unique_ptr<Slam, DeleteReleased>;

SlamHolder make_slam(const CameraParameters& camera, SensorType sensor, const std::optional<RightCamera>& right,
                     Timing timing, Mode mode, const std::string& map, const std::string& vocabulary,
                     const py::dict& settings) {
  SlamOptions options;
  options.sensor = sensor;
  options.camera = camera;
  options.right = right;
  options.timing = timing;
  options.mode = mode;
  options.map = map;
  options.vocabulary = vocabulary;
  options.settings = to_settings(settings);
  const py::gil_scoped_release released;
  return SlamHolder(value_of(Slam::create(options)).release());
}

void bind_enums(py::module_& m) {
  py::enum_<SensorType>(m, "Sensor")
      .value("monocular", SensorType::monocular)
      .value("stereo", SensorType::stereo)
      .value("rgbd", SensorType::rgbd);
  py::enum_<LensType>(m, "Lens")
      .value("none", LensType::none)
      .value("brown_conrady", LensType::brown_conrady)
      .value("kannala_brandt", LensType::kannala_brandt);
  py::enum_<Timing>(m, "Timing").value("realtime", Timing::realtime).value("deterministic", Timing::deterministic);
  py::enum_<Mode>(m, "Mode").value("mapping", Mode::mapping).value("localisation", Mode::localisation);
  py::enum_<ColourOrder>(m, "ColourOrder").value("rgb", ColourOrder::rgb).value("bgr", ColourOrder::bgr);
  py::enum_<TrackingState> state(m, "TrackingState");
  for (const auto s : {TrackingState::not_initialised, TrackingState::tracking, TrackingState::lost})
    state.value(name(s), s);
  py::enum_<NoPoseReason> reason(m, "NoPoseReason", "Why a frame has no pose; describe(reason) says it in words.");
  for (int k = 0; k <= static_cast<int>(NoPoseReason::no_key_frame_matches); ++k)
    reason.value(name(static_cast<NoPoseReason>(k)), static_cast<NoPoseReason>(k));
  py::enum_<Event::Kind> kind(m, "EventKind");
  for (int k = 0; k <= static_cast<int>(Event::Kind::sensor_doubted); ++k)
    kind.value(name(static_cast<Event::Kind>(k)), static_cast<Event::Kind>(k));
  py::enum_<LogLevel>(m, "LogLevel")
      .value("debug", LogLevel::debug)
      .value("info", LogLevel::info)
      .value("warning", LogLevel::warning)
      .value("error", LogLevel::error);
}

void bind_values(py::module_& m) {
  py::class_<Pose>(m, "Pose", "T_wc, camera to world: metres and a unit quaternion.")
      .def(py::init([](double x, double y, double z, double qx, double qy, double qz, double qw) {
             return Pose{x, y, z, qx, qy, qz, qw};
           }),
           py::arg("x") = 0., py::arg("y") = 0., py::arg("z") = 0., py::arg("qx") = 0., py::arg("qy") = 0.,
           py::arg("qz") = 0., py::arg("qw") = 1.)
      .def_static("from_matrix", &pose_of_matrix, py::arg("matrix"), "The pose of a 4 x 4 matrix.")
      .def_property_readonly("matrix", &matrix_of, "4 x 4, float64.")
      .def_readwrite("x", &Pose::x)
      .def_readwrite("y", &Pose::y)
      .def_readwrite("z", &Pose::z)
      .def_readwrite("qx", &Pose::qx)
      .def_readwrite("qy", &Pose::qy)
      .def_readwrite("qz", &Pose::qz)
      .def_readwrite("qw", &Pose::qw)
      .def("__repr__", &text);
  py::class_<CameraParameters>(m, "Camera", "Figures in pixels; baseline in metres (rectified stereo pairs).")
      .def(py::init(&make_camera), py::arg("width"), py::arg("height"), py::arg("fx"), py::arg("fy"), py::arg("cx"),
           py::arg("cy"), py::kw_only(), py::arg("baseline") = 0., py::arg("lens") = LensType::none,
           py::arg("distortion") = std::vector<double>(), py::arg("depth_sigma_a") = 0., py::arg("depth_sigma_b") = 0.)
      .def_readonly("width", &CameraParameters::width)
      .def_readonly("height", &CameraParameters::height)
      .def_readonly("fx", &CameraParameters::fx)
      .def_readonly("fy", &CameraParameters::fy)
      .def_readonly("cx", &CameraParameters::cx)
      .def_readonly("cy", &CameraParameters::cy)
      .def_readonly("baseline", &CameraParameters::baseline)
      .def_readonly("lens", &CameraParameters::lens)
      .def_property_readonly("distortion",
                             [](const CameraParameters& c) {
                               return std::vector<double>(std::begin(c.distortion), std::end(c.distortion));
                             })
      .def_readonly("depth_sigma_a", &CameraParameters::depth_sigma_a)
      .def_readonly("depth_sigma_b", &CameraParameters::depth_sigma_b);
  py::class_<RightCamera>(m, "RightCamera", "The right camera of a stereo pair that is not rectified.")
      .def(py::init([](const CameraParameters& camera, const Pose& pose) {
             return RightCamera{camera, pose};
           }),
           py::arg("camera"), py::arg("pose"))
      .def_readonly("camera", &RightCamera::camera)
      .def_readonly("pose", &RightCamera::pose, "The right camera's pose in the left one's coordinates.");
  py::class_<FrameResult>(m, "FrameResult")
      .def_readonly("state", &FrameResult::state)
      .def_property_readonly("tracked", &FrameResult::tracked, "The frame has a pose.")
      .def_readonly("reason", &FrameResult::reason, "Why there is no pose.")
      .def_property_readonly(
          "pose", [](const FrameResult& r) { return r.tracked() ? std::optional(r.pose) : std::nullopt; },
          "None without a pose.")
      .def_readonly("submap", &FrameResult::submap)
      .def_readonly("tentative", &FrameResult::tentative)
      .def_readonly("dead_reckoned", &FrameResult::dead_reckoned)
      .def_readonly("retracted_from", &FrameResult::retracted_from,
                    "Frames from this stamp on have lost their poses: the place proved wrong.")
      .def_readonly("inliers", &FrameResult::inliers)
      .def_readonly("key_frame", &FrameResult::key_frame)
      .def_property_readonly(
          "covariance", [](const FrameResult& r) { return to_array(r.covariance); },
          "6 x 6 of x, y, z (metres) and turns about the world's axes (radians); None where it is not known.")
      .def("__repr__", [](const FrameResult& r) {
        return r.tracked() ? "FrameResult(tracking, " + text(r.pose) + ")"
                           : std::string("FrameResult(") + name(r.state) + ": " + describe(r.reason) + ")";
      });
  py::class_<Location>(m, "Location")
      .def_readonly("pose", &Location::pose)
      .def_readonly("submap", &Location::submap)
      .def_readonly("inliers", &Location::inliers)
      .def_property_readonly(
          "covariance", [](const Location& l) { return to_array(l.covariance); }, "As FrameResult.covariance.");
  py::class_<Event>(m, "Event")
      .def_readonly("kind", &Event::kind)
      .def_readonly("stamp", &Event::stamp)
      .def_readonly("submap", &Event::submap)
      .def_readonly("ended", &Event::ended, "submaps_joined: id of the submap that is none any more.")
      .def_readonly("key_frame", &Event::key_frame)
      .def_readonly("place", &Event::place)
      .def_readonly("reason", &Event::reason);
  py::class_<Setting>(m, "Setting")
      .def_readonly("name", &Setting::name)
      .def_readonly("value", &Setting::value)
      .def_readonly("min", &Setting::min)
      .def_readonly("max", &Setting::max)
      .def_readonly("description", &Setting::description);
}

void bind_snapshot(py::module_& m) {
  using S = MapSnapshot;
  // Columns are views of the snapshot, which lives as long as they.
  const auto column = [](auto list, size_t columns, auto member) {
    return [=](const py::object& self) { return column_of(self.cast<const S&>().*list, columns, member, self); };
  };
  py::class_<S::Submap>(m, "Submap")
      .def_readonly("id", &S::Submap::id)
      .def_readonly("loaded", &S::Submap::loaded)
      .def_readonly("frames", &S::Submap::frames)
      .def_readonly("key_frames", &S::Submap::key_frames)
      .def_readonly("points", &S::Submap::points);
  py::class_<S, std::shared_ptr<S>>(m, "Snapshot",
                                    "The map and the trajectory at one moment. Arrays are views that can't be written.")
      .def_readonly("revision", &S::revision)
      .def_readonly("camera", &S::camera)
      .def_readonly("submaps", &S::submaps)
      .def_property_readonly("points",
                             column(
                                 &S::points, 3, [](auto& p) -> auto& { return p.x; }),
                             "(n, 3), metres.")
      .def_property_readonly("point_ids", column(
                                              &S::points, 0, [](auto& p) -> auto& { return p.id; }))
      .def_property_readonly("point_submaps", column(
                                                  &S::points, 0, [](auto& p) -> auto& { return p.submap; }))
      .def_property_readonly("point_colours",
                             column(
                                 &S::points, 3, [](auto& p) -> auto& { return p.colour[0]; }),
                             "(n, 3), uint8: red, green, blue; grey where no image came with colours.")
      .def_property_readonly("key_frame_ids", column(
                                                  &S::key_frames, 0, [](auto& k) -> auto& { return k.id; }))
      .def_property_readonly("key_frame_stamps",
                             column(
                                 &S::key_frames, 0, [](auto& k) -> auto& { return k.stamp; }),
                             "Nanoseconds.")
      .def_property_readonly("key_frame_frames", column(
                                                     &S::key_frames, 0, [](auto& k) -> auto& { return k.frame; }))
      .def_property_readonly("key_frame_submaps", column(
                                                      &S::key_frames, 0, [](auto& k) -> auto& { return k.submap; }))
      .def_property_readonly("key_frame_parents",
                             column(
                                 &S::key_frames, 0, [](auto& k) -> auto& { return k.parent; }),
                             "Indices; -1 for a root.")
      .def_property_readonly("key_frame_positions",
                             column(
                                 &S::key_frames, 3, [](auto& k) -> auto& { return k.pose.x; }),
                             "(n, 3), metres.")
      .def_property_readonly("key_frame_quaternions",
                             column(
                                 &S::key_frames, 4, [](auto& k) -> auto& { return k.pose.qx; }),
                             "(n, 4), x y z w.")
      .def_property_readonly("edges",
                             column(
                                 &S::edges, 2, [](auto& e) -> auto& { return e.a; }),
                             "(n, 2), indices of key frames.")
      .def_property_readonly("edge_shared", column(
                                                &S::edges, 0, [](auto& e) -> auto& { return e.shared; }))
      .def_property_readonly("edge_loops", column(
                                               &S::edges, 0, [](auto& e) -> auto& { return e.loop; }))
      .def_property_readonly("observations",
                             column(
                                 &S::observations, 2, [](auto& o) -> auto& { return o.key_frame; }),
                             "(n, 2), indices of a key frame and a point.")
      .def_property_readonly("observation_pixels",
                             column(
                                 &S::observations, 2, [](auto& o) -> auto& { return o.u; }),
                             "(n, 2).")
      .def_property_readonly("stamps",
                             column(
                                 &S::trajectory, 0, [](auto& t) -> auto& { return t.stamp; }),
                             "Of the trajectory, nanoseconds.")
      .def_property_readonly("positions",
                             column(
                                 &S::trajectory, 3, [](auto& t) -> auto& { return t.pose.x; }),
                             "Of the trajectory, (n, 3), metres.")
      .def_property_readonly("quaternions",
                             column(
                                 &S::trajectory, 4, [](auto& t) -> auto& { return t.pose.qx; }),
                             "Of the trajectory, (n, 4), x y z w.")
      .def_property_readonly("trajectory_submaps", column(
                                                       &S::trajectory, 0, [](auto& t) -> auto& { return t.submap; }));
}

void bind_slam(py::module_& m) {
  py::class_<Slam, SlamHolder>(m, "Slam",
                               "A SLAM system: frames in, poses and a map out. Settings are given by name and value.")
      .def(py::init(&make_slam), py::arg("camera"), py::arg("sensor"), py::kw_only(), py::arg("right") = std::nullopt,
           py::arg("timing") = Timing::realtime, py::arg("mode") = Mode::mapping, py::arg("map") = "",
           py::arg("vocabulary") = "", py::arg("settings") = py::dict())
      .def(
          "track",
          [](Slam& slam, int64_t stamp, const py::object& image, const py::object& right, const py::object& depth,
             const py::object& colour, ColourOrder order) {
            const Frame frame = to_frame(stamp, image, right, depth, colour, order);
            const py::gil_scoped_release released;
            return value_of(slam.track(frame));
          },
          py::arg("stamp"), py::arg("image") = py::none(), py::kw_only(), py::arg("right") = py::none(),
          py::arg("depth") = py::none(), py::arg("colour") = py::none(), py::arg("order") = ColourOrder::rgb,
          "Tracks one frame: stamp in nanoseconds; image and right (height, width) uint8; depth float32, metres; "
          "colour "
          "(height, width, 3) uint8, for the colours of the map's points, and in place of image where that is None.")
      .def(
          "locate",
          [](Slam& slam, const py::object& image, const py::object& right, const py::object& depth,
             const py::object& colour, ColourOrder order) {
            const Frame frame = to_frame(0, image, right, depth, colour, order);
            const py::gil_scoped_release released;
            return value_of(slam.locate(frame));
          },
          py::arg("image") = py::none(), py::kw_only(), py::arg("right") = py::none(), py::arg("depth") = py::none(),
          py::arg("colour") = py::none(), py::arg("order") = ColourOrder::rgb,
          "The Location of one image in the present map; None when its place is not recognised.")
      .def(
          "tracked_points",
          [](Slam& slam) {
            auto* points = new std::vector<TrackedPoint>(slam.tracked_points());
            const py::capsule owner(points, [](void* p) { delete static_cast<std::vector<TrackedPoint>*>(p); });
            return py::make_tuple(column_of(
                                      *points, 2, [](auto& p) -> auto& { return p.u; }, owner),
                                  column_of(
                                      *points, 0, [](auto& p) -> auto& { return p.point; }, owner),
                                  column_of(
                                      *points, 3, [](auto& p) -> auto& { return p.x; }, owner));
          },
          "Of the last frame: pixels (n, 2), ids of the points (n), their places in the world (n, 3).")
      .def("finish", &Slam::finish, Released(), "Waits for mapping, and locates frames that got no pose.")
      .def("reset", &Slam::reset, Released(), "Forgets the map and the trajectory.")
      .def(
          "load_map", [](Slam& s, const std::string& file) { value_of(s.load_map(file)); }, py::arg("file"), Released())
      .def(
          "save_map", [](const Slam& s, const std::string& file) { value_of(s.save_map(file)); }, py::arg("file"),
          Released())
      .def_property("mode", &Slam::mode,
                    py::cpp_function([](Slam& s, Mode mode) { value_of(s.set_mode(mode)); }, Released()))
      .def("on_event", &Slam::on_event, py::arg("handler"), "Calls handler(event) from inside track() and finish().")
      .def(
          "snapshot", [](const Slam& s) { return std::const_pointer_cast<MapSnapshot>(s.snapshot()); }, Released())
      .def_property_readonly("camera", py::cpp_function(&Slam::camera, Released()), "The camera in use.")
      .def_property_readonly("rectified_left", &Slam::rectified_left)
      .def_property_readonly("settings", &Slam::settings);
}

}  // namespace

PYBIND11_MODULE(_covis, m) {
  m.doc() = "Visual SLAM for monocular, stereo and RGB-D cameras.";
  m.attr("__version__") = version();
  py::register_exception<CovisError>(m, "Error", PyExc_RuntimeError);
  bind_enums(m);
  bind_values(m);
  bind_snapshot(m);
  bind_slam(m);
  bind_recordings(m);
  m.def("describe", py::overload_cast<NoPoseReason>(&describe), py::arg("reason"));
  m.def("default_settings", &default_settings);
  m.def("set_log_sink", &set_log_sink, py::arg("sink"), Released(),
        "Calls sink(level, message) for each message of the library, from any thread; None drops them.");
  // The sink is a function of the interpreter, and ends with it.
  py::module_::import("atexit").attr("register")(py::cpp_function([] { set_log_sink({}); }, Released()));
}

}  // namespace covis::python
