// SPDX-License-Identifier: Apache-2.0
// The Python module covis._covis: include/covis as it is, with NumPy arrays for images and lists of points.
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"

namespace covis::python {
namespace {

// The interpreter's lock is released in every call that may take long or write a message: a message waits for it in the
// thread that writes.
using Released = py::call_guard<py::gil_scoped_release>;

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
    if (text == "True" || text == "False") text = text == "True" ? "true" : "false";  // NumPy's too
    list.emplace_back(py::str(name), text);
  }
  return list;
}

thread_local bool in_sink = false;  // this thread calls the log sink at present

// A sink that calls the library may be called again by what that says.
struct InSink {
  InSink() : outer(std::exchange(in_sink, true)) {}
  ~InSink() { in_sink = outer; }
  InSink(const InSink&) = delete;
  InSink& operator=(const InSink&) = delete;
  const bool outer;
};

// Ending a system waits for its threads, whose messages may wait for the interpreter's lock. Where a thread of its own
// drops it, in a log sink or in the garbage collection that one sets off, the main thread ends it instead.
struct DeleteReleased {
  void operator()(Slam* slam) const {
    if (in_sink && Py_AddPendingCall(&end, slam) == 0) return;
    end(slam);
  }
  static int end(void* slam) {
    const py::gil_scoped_release released;
    delete static_cast<Slam*>(slam);
    return 0;
  }
};
using SlamHolder = std::unique_ptr<Slam, DeleteReleased>;

SlamHolder make_slam(const CameraParameters& camera, SensorType sensor, const std::optional<RightCamera>& right,
                     Timing timing, Mode mode, const std::filesystem::path& map,
                     const std::filesystem::path& vocabulary, const py::dict& settings) {
  SlamOptions options;
  options.sensor = sensor;
  options.camera = camera;
  options.right = right;
  options.timing = timing;
  options.mode = mode;
  options.map = map.string();
  options.vocabulary = vocabulary.string();
  options.settings = to_settings(settings);
  const py::gil_scoped_release released;
  return SlamHolder(value_of(Slam::create(options)).release());
}

void bind_slam(py::module_& m) {
  py::class_<Slam, SlamHolder>(m, "Slam",
                               "A SLAM system: frames in, poses and a map out. right: the other camera of a pair that "
                               "is not rectified; map: the file of a saved map to continue or localise in; vocabulary: "
                               "the file to recognise places by, see default_vocabulary(); settings: values by name, "
                               "see default_settings().")
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
          "Tracks one frame and returns its FrameResult. stamp: nanoseconds, rising; image and right: (height, width), "
          "uint8; depth: (height, width), float32, metres; colour: (height, width, 3), uint8, for the colours of the "
          "map's points, and in place of image where that is None.")
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
          "The Location of one image in the present map; None when its place is not recognised. image and "
          "right: (height, width), uint8; depth: (height, width), float32, metres; colour: (height, width, 3), uint8.")
      .def(
          "tracked_points",
          [](Slam& slam) {
            auto* points = new std::vector<TrackedPoint>(slam.tracked_points());
            const py::capsule owner(points, [](void* p) { delete static_cast<std::vector<TrackedPoint>*>(p); });
            return py::make_tuple(column_of(*points, 2, COVIS_MEMBER(u), owner),
                                  column_of(*points, 0, COVIS_MEMBER(point), owner),
                                  column_of(*points, 3, COVIS_MEMBER(x), owner));
          },
          "Three arrays of the last frame's keypoints that show points of the map, none without a pose: pixels (n, 2), "
          "float64; ids of the points (n), uint64; places in the world (n, 3), float64, metres.")
      .def("finish", &Slam::finish, Released(), "Waits for mapping, and locates frames that got no pose.")
      .def("reset", &Slam::reset, Released(), "Forgets the map and the trajectory.")
      .def(
          "load_map", [](Slam& s, const std::filesystem::path& file) { value_of(s.load_map(file.string())); },
          py::arg("file"), Released(), "Puts a saved map in place of the present one, to be continued or localised in.")
      .def(
          "save_map", [](const Slam& s, const std::filesystem::path& file) { value_of(s.save_map(file.string())); },
          py::arg("file"), Released(), "Saves the map to one file; call finish() before, to have all of it.")
      .def_property("mode", &Slam::mode,
                    py::cpp_function([](Slam& s, Mode mode) { value_of(s.set_mode(mode)); }, Released()),
                    "The Mode; setting it changes between mapping and localisation from the next frame on.")
      .def("on_event", &Slam::on_event, py::arg("handler"),
           "Calls handler(event) for each Event, from inside track(), finish() and setting mode; None ends it. A "
           "handler that names its Slam keeps it alive until then.")
      .def(
          "snapshot", [](const Slam& s) { return std::const_pointer_cast<MapSnapshot>(s.snapshot()); }, Released(),
          "The map and the trajectory as they are now: a Snapshot.")
      .def_property_readonly(
          "camera", py::cpp_function(&Slam::camera, Released()),
          "The Camera in use: its focal length, distortion, readout and noise of depth as estimated so far.")
      .def_property_readonly("rectified_left", &Slam::rectified_left,
                             "The rectified left camera's Pose in the given one's coordinates, a rotation; the "
                             "identity for pairs that are not rectified here.")
      .def_property_readonly("settings", &Slam::settings, "List of Setting: those in use.");
}

// The library drops what a sink throws; here it is reported first.
void set_reported_sink(std::function<void(LogLevel, py::object)> sink) {
  if (!sink) return set_log_sink({});
  set_log_sink([sink = std::move(sink)](LogLevel level, std::string_view message) {
    const py::gil_scoped_acquire interpreter;
    const InSink called;
    try {
      sink(level, text_of(message));
    } catch (py::error_already_set& raised) {
      raised.discard_as_unraisable("the log sink of covis");
    }
  });
}

void bind_error(py::module_& m) {
  static const py::handle error = py::exception<CovisError>(m, "Error", PyExc_RuntimeError).release();
  error.attr("__doc__") = "What the library refuses; the message names the argument, the file or the setting.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const CovisError& refused) {
      PyErr_SetObject(error.ptr(), text_of(refused.what()).ptr());
    }
  });
}

}  // namespace

PYBIND11_MODULE(_covis, m) {
  m.doc() = "Visual SLAM for monocular, stereo and RGB-D cameras.";
  m.attr("__version__") = version();
  bind_error(m);
  bind_values(m);
  bind_snapshot(m);
  bind_slam(m);
  bind_recordings(m);
  m.def("describe", py::overload_cast<NoPoseReason>(&describe), py::arg("reason"),
        "The reason in words; empty for none.");
  m.def("default_settings", &default_settings, "List of Setting: all of them, with their defaults.");
  m.def(
      "set_log_sink", &set_reported_sink, py::arg("sink"), Released(),
      "Calls sink(level, message) for each message of the library, from any thread; None drops them. What it raises is "
      "reported as sys.unraisablehook does.");
  // The sink is a function of the interpreter, and ends with it.
  py::module_::import("atexit").attr("register")(py::cpp_function([] { set_log_sink({}); }, Released()));
}

}  // namespace covis::python
