// SPDX-License-Identifier: Apache-2.0
// Recordings, trajectories and errors for the Python module: what the command has, as objects.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>

#include "arrays.h"
#include "covis/api/convert.h"
#include "covis/eval/evaluation.h"
#include "covis/io/sequence.h"
#include "next_frame.h"

namespace covis::python {
namespace {

template <class T>
T value(Result<T> result) {
  if (!result) throw CovisError(result.error().message);
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

template <class Enum>
Enum choose(const char* what, const std::string& text, const std::vector<std::pair<const char*, Enum>>& choices) {
  std::string known;
  for (const auto& [name, choice] : choices) {
    if (text == name) return choice;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  std::string message = what;  // piece by piece: GCC 12 warns of a sum of strings here, wrongly
  for (const std::string& piece : {std::string(": '"), text, std::string("' is none of "), known}) message += piece;
  throw py::value_error(message);
}

// ---- Trajectories ----

io::TrajectoryFormat format_of(const std::string& text) {
  using F = io::TrajectoryFormat;
  return choose<F>("format", text,
                   {{"automatic", F::automatic}, {"tum", F::tum}, {"kitti", F::kitti}, {"euroc", F::euroc}});
}

// Flat copies of a trajectory, for NumPy.
struct PyTrajectory {
  std::vector<TrajectoryPose> poses;
  bool stamped = true;  // false: the stamps are numbers of rows, of a file that has none

  static PyTrajectory of(const Trajectory& trajectory) {
    PyTrajectory made;
    for (const StampedPose& pose : trajectory) made.poses.push_back({pose.stamp, to_pose(pose.T_wc), 0});
    return made;
  }
  // Each submap has a world of its own. That of the most poses is first, of equals the earlier one.
  std::vector<Trajectory> by_submap() const {
    std::vector<Trajectory> all;
    std::map<uint32_t, size_t> index;
    for (const TrajectoryPose& pose : poses) {
      const size_t k = index.emplace(pose.submap, all.size()).first->second;
      if (k == all.size()) all.emplace_back();
      all[k].push_back({pose.stamp, to_se3(pose.pose)});
    }
    std::ranges::stable_sort(all, std::greater(), &Trajectory::size);
    if (all.empty()) all.emplace_back();
    return all;
  }
};

// Quaternions may be as inexact as those in a file of trajectories (io/trajectory.h).
PyTrajectory from_arrays(const std::vector<int64_t>& stamps,
                         const py::array_t<double, py::array::c_style | py::array::forcecast>& positions,
                         const py::array_t<double, py::array::c_style | py::array::forcecast>& quaternions) {
  const auto n = static_cast<py::ssize_t>(stamps.size());
  if (positions.ndim() != 2 || positions.shape(0) != n || positions.shape(1) != 3)
    throw py::value_error("positions: a shape (n, 3) with a row for each stamp is wanted");
  if (quaternions.ndim() != 2 || quaternions.shape(0) != n || quaternions.shape(1) != 4)
    throw py::value_error("quaternions: a shape (n, 4) with a row for each stamp is wanted");
  const auto p = positions.unchecked<2>(), q = quaternions.unchecked<2>();
  PyTrajectory made;
  for (py::ssize_t i = 0; i < n; ++i) {
    const Pose pose{p(i, 0), p(i, 1), p(i, 2), q(i, 0), q(i, 1), q(i, 2), q(i, 3)};
    const auto refuse = [i](const std::string& what) { throw py::value_error(what + " in row " + std::to_string(i)); };
    if (!std::isfinite(pose.x + pose.y + pose.z)) refuse("positions: finite numbers are wanted");
    const double norm = std::sqrt(pose.qx * pose.qx + pose.qy * pose.qy + pose.qz * pose.qz + pose.qw * pose.qw);
    if (!(std::abs(norm - 1) < 1e-2)) refuse("quaternions: a unit quaternion is wanted");
    const double by = std::abs(norm - 1) < 1e-9 ? 1 : norm;
    const Pose unit{pose.x, pose.y, pose.z, pose.qx / by, pose.qy / by, pose.qz / by, pose.qw / by};
    made.poses.push_back({stamps[static_cast<size_t>(i)], unit, 0});
  }
  return made;
}

PyTrajectory load_trajectory(const std::filesystem::path& file, io::TrajectoryFormat format,
                             const std::filesystem::path& stamps) {
  format = value(io::trajectory_format(file, format));
  if (io::has_stamps(format) && !stamps.empty())
    throw CovisError(stamps.string() + ": " + file.string() + " has stamps of its own");
  PyTrajectory made = PyTrajectory::of(value(io::read_trajectory(file, format, stamps)));
  made.stamped = format != io::TrajectoryFormat::kitti || !stamps.empty();
  return made;
}

void bind_trajectory(py::module_& m) {
  const auto column = [](size_t columns, auto member) {
    return [=](const py::object& self) {
      return column_of(self.cast<const PyTrajectory&>().poses, columns, member, self);
    };
  };
  py::class_<PyTrajectory>(m, "Trajectory",
                           "Stamped poses, camera to world: stamps (n), nanoseconds; positions (n, 3), metres; "
                           "quaternions (n, 4), of length 1, x y z w. An index gives a Pose.")
      .def(py::init(&from_arrays), py::arg("stamps"), py::arg("positions"), py::arg("quaternions"))
      .def_static(
          "load",
          [](const std::filesystem::path& file, const std::string& format, const std::filesystem::path& stamps) {
            return load_trajectory(file.string(), format_of(format), stamps.string());
          },
          py::arg("file"), py::arg("format") = "automatic", py::arg("stamps") = "",
          "Reads a file of the format tum, kitti or euroc; stamps: the file of stamps (seconds, one for each "
          "row) beside one of kitti.")
      .def(
          "save",
          [](const PyTrajectory& t, const std::filesystem::path& file, const std::string& format) {
            value(io::write_trajectories(file.string(), t.by_submap(), format_of(format)));
          },
          py::arg("file"), py::arg("format") = "tum",
          "Writes a file of the format tum, kitti or euroc. Submaps have worlds of their own and so files of their "
          "own: that of the most poses is FILE, the others FILE_map1 and so on, as covis run names them. The "
          "stamps of kitti's rows, which have none, go to FILE_times.")
      .def("__len__", [](const PyTrajectory& t) { return t.poses.size(); })
      .def("__getitem__",
           [](const PyTrajectory& t, py::ssize_t i) {
             const auto n = static_cast<py::ssize_t>(t.poses.size());
             if (i < -n || i >= n) throw py::index_error();
             return t.poses[static_cast<size_t>(i < 0 ? i + n : i)].pose;
           })
      .def_property_readonly("stamps", column(0, COVIS_MEMBER(stamp)), "(n), int64: nanoseconds.")
      .def_property_readonly("positions", column(3, COVIS_MEMBER(pose.x)), "(n, 3), float64: metres.")
      .def_property_readonly("quaternions", column(4, COVIS_MEMBER(pose.qx)), "(n, 4), float64: x y z w.")
      .def_property_readonly("submaps", column(0, COVIS_MEMBER(submap)),
                             "(n), int32: ids of the submaps whose worlds the poses are in.");
  m.def(
      "_trajectory_of", [](const Slam& slam) { return PyTrajectory{slam.trajectory()}; },
      py::call_guard<py::gil_scoped_release>());
}

// ---- Errors ----

struct PyEvaluation {
  Evaluation evaluation;
  std::vector<std::array<double, 3>> estimate, truth;
  std::vector<double> errors;
};

PyEvaluation evaluate_both(const PyTrajectory& estimate, const PyTrajectory& truth, const std::string& align,
                           double max_difference) {
  EvaluationOptions options;
  options.align = choose<AlignMode>("align", align,
                                    {{"se3", AlignMode::se3},
                                     {"sim3", AlignMode::sim3},
                                     {"none", AlignMode::none},
                                     {"first", AlignMode::first},
                                     {"first-sim3", AlignMode::first_sim3}});
  if (!(max_difference > 0) || !std::isfinite(max_difference))
    throw py::value_error("max_difference: a positive number of seconds is wanted");
  options.max_difference = max_difference;
  if (estimate.stamped != truth.stamped || (!estimate.stamped && estimate.poses.size() != truth.poses.size()))
    throw CovisError("the rows of " + std::string(estimate.stamped ? "the truth have" : "the estimate have") +
                     " no stamps, so that it is not known which poses belong together (" +
                     std::to_string(estimate.poses.size()) + " and " + std::to_string(truth.poses.size()) +
                     "); Trajectory.load(file, stamps=...) reads those of each row from a file");
  PyEvaluation made;
  {
    const py::gil_scoped_release released;
    made.evaluation = value(evaluate(estimate.by_submap().front(), truth.by_submap().front(), options));
  }
  for (const ComparedPose& pose : made.evaluation.compared) {
    const auto put = [](const SE3& T) { return std::array{T.t().x(), T.t().y(), T.t().z()}; };
    made.estimate.push_back(put(pose.estimate));
    made.truth.push_back(put(pose.truth));
    made.errors.push_back(pose.error);
  }
  return made;
}

void bind_evaluation(py::module_& m) {
  const auto positions = [](auto list) {
    return [=](const py::object& self) {
      const auto& rows = self.cast<const PyEvaluation&>().*list;
      return column_of(
          rows, 3, [](auto& row) -> auto& { return row[0]; }, self);
    };
  };
  const auto figure = [](auto get) { return [=](const PyEvaluation& e) { return get(e.evaluation); }; };
  py::class_<PyEvaluation>(m, "Evaluation", "How far a trajectory is from the truth.")
      .def_property_readonly("ate_rmse", figure([](const Evaluation& e) { return e.ate.rmse; }),
                             "Root of the mean square error of position, metres.")
      .def_property_readonly("scale", figure([](const Evaluation& e) { return e.scale; }),
                             "Factor that fits the estimate to the truth (sim3); else 1.")
      .def_property_readonly("coverage", figure([](const Evaluation& e) { return e.coverage; }),
                             "Share of the true poses that have an estimate.")
      .def_property_readonly("path_length", figure([](const Evaluation& e) { return e.path_length; }),
                             "Length of the true path, metres.")
      .def_property_readonly(
          "figures",
          [](const PyEvaluation& e) { return py::module_::import("json").attr("loads")(to_json(e.evaluation).dump()); },
          "Dict of all figures, as `covis eval --json` gives them.")
      .def_property_readonly("estimate", positions(&PyEvaluation::estimate),
                             "(n, 3), float64: places aligned to the truth, metres.")
      .def_property_readonly("truth", positions(&PyEvaluation::truth), "(n, 3), float64: true places, metres.")
      .def_property_readonly(
          "errors",
          [](const py::object& self) {
            const auto& e = self.cast<const PyEvaluation&>().errors;
            return view_of(e.data(), e.size(), 0, sizeof(double), self);
          },
          "(n), float64: distances of the two, metres.")
      .def("__str__", figure([](const Evaluation& e) { return to_text(e); }));
  m.def("evaluate", &evaluate_both, py::arg("estimate"), py::arg("truth"), py::arg("align") = "se3",
        py::arg("max_difference") = 0.02,
        "The Evaluation of a Trajectory against the true one. align: se3, sim3, none, first or first-sim3; "
        "max_difference: greatest time between a pose and its true one, seconds.");
}

// ---- Recordings ----

struct PyRecording {
  std::atomic<int> stop = 0;  // of a wait for a camera
  std::atomic<int64_t> frames = 0, unreadable = 0;
  std::mutex picture_mutex;  // held while a picture is read
  std::unique_ptr<io::Sequence> sequence;
};

std::unique_ptr<PyRecording> open(const std::filesystem::path& path, const std::string& kind, const std::string& sensor,
                                  const std::filesystem::path& camera_file, int64_t first, int64_t count, int stride,
                                  const io::TopicNames& topics, bool skip_bad) {
  auto recording = std::make_unique<PyRecording>();
  io::SequenceOptions options;
  using K = io::SequenceKind;
  options.kind = choose<K>("kind", kind,
                           {{"automatic", K::automatic},
                            {"tum", K::tum},
                            {"kitti", K::kitti},
                            {"euroc", K::euroc},
                            {"tartanair", K::tartanair},
                            {"openloris", K::openloris},
                            {"open3d", K::open3d},
                            {"bag", K::bag},
                            {"images", K::images},
                            {"video", K::video},
                            {"camera", K::camera}});
  if (!sensor.empty())
    options.sensor = choose<Sensor>("sensor", sensor,
                                    {{"mono", Sensor::monocular}, {"stereo", Sensor::stereo}, {"rgbd", Sensor::rgbd}});
  options.camera_file = camera_file.string();
  options.first = first;
  options.count = count;
  options.stride = stride;
  options.topics = topics;
  options.skip_bad = skip_bad;
  options.stop = &recording->stop;
  const py::gil_scoped_release released;
  recording->sequence = value(io::open_sequence(path.string(), options));
  return recording;
}

// A handler of signals, as that of Ctrl-C, runs while a camera is waited for, and what it raises ends the wait.
io::Frame next_frame(PyRecording& recording) {
  bool raised = false;
  auto next = [&] {
    const py::gil_scoped_release released;
    return next_readable(*recording.sequence, recording.stop, recording.unreadable, [&] {
      const py::gil_scoped_acquire acquired;
      raised = raised || PyErr_CheckSignals() != 0;
      return raised;
    });
  }();
  if (raised) throw py::error_already_set();
  std::optional<io::Frame> frame = value(std::move(next));
  if (frame) {
    ++recording.frames;
    return std::move(*frame);
  }
  if (recording.frames == 0 && recording.unreadable > 0)
    throw CovisError("no frame could be read of " + std::to_string(recording.unreadable) + "; the log says why");
  throw py::stop_iteration();
}

SensorType public_sensor(Sensor sensor) {
  return sensor == Sensor::monocular ? SensorType::monocular
         : sensor == Sensor::stereo  ? SensorType::stereo
                                     : SensorType::rgbd;
}

// The arrays of a frame are views of its images, which live as long as they.
template <class Image>
py::object array_of(const Image& image, const py::object& self) {
  if (image.empty()) return py::none();
  using T = std::remove_cvref_t<decltype(*image.row(0))>;
  return view_of<T>(image.row(0), static_cast<size_t>(image.height()), static_cast<size_t>(image.width()),
                    static_cast<size_t>(image.stride()) * sizeof(T), self);
}

py::object picture_array(PyRecording& recording, int64_t frame) {
  auto* picture = new io::Picture([&] {
    const py::gil_scoped_release released;
    const std::lock_guard lock(recording.picture_mutex);
    return value(recording.sequence->picture(frame));
  }());
  const py::capsule owner(picture, [](void* p) { delete static_cast<io::Picture*>(p); });
  std::vector<py::ssize_t> shape{picture->height, picture->width};
  if (picture->coloured()) shape.push_back(3);
  return py::array_t<uint8_t>(shape, picture->bytes.data(), owner);
}

}  // namespace

void bind_recordings(py::module_& m) {
  bind_trajectory(m);
  bind_evaluation(m);
  const auto image = [](auto member) {
    return [=](const py::object& self) { return array_of(self.cast<const io::Frame&>().*member, self); };
  };
  py::class_<io::Frame>(m, "RecordedFrame", "The images of one moment. Arrays are views that can't be written.")
      .def_readonly("index", &io::Frame::index, "Its number in the recording, from 0.")
      .def_readonly("stamp", &io::Frame::stamp, "Nanoseconds.")
      .def_property_readonly("image", image(&io::Frame::image),
                             "(height, width), uint8: the grey image, the left one of a pair.")
      .def_property_readonly("right", image(&io::Frame::right),
                             "(height, width), uint8: the right image; None but for stereo.")
      .def_property_readonly("depth", image(&io::Frame::depth),
                             "(height, width), float32: metres along z, 0 for none; None but for RGB-D.");
  py::class_<PyRecording>(
      m, "Recording",
      "A recording, a video or a camera as a stream of frames: iterate over it. kind (tum, kitti, euroc, "
      "…) and sensor (mono, stereo, rgbd) are found unless given; camera_file: its figures where "
      "the recording has none; first, count, stride: the frames wanted; topic, right_topic, depth_topic: those of a "
      "bag, where it has several; skip_bad: frames that lack a file, and stamps that do not rise, are left out, "
      "however many. Iterating "
      "leaves out a frame that can't be read, with a warning in the log, and waits for a camera that went away.")
      .def(py::init([](const std::filesystem::path& path, const std::string& kind, const std::string& sensor,
                       const std::filesystem::path& camera_file, int64_t first, int64_t count, int stride,
                       const std::string& topic, const std::string& right_topic, const std::string& depth_topic,
                       bool skip_bad) {
             return open(path, kind, sensor, camera_file, first, count, stride, {topic, right_topic, depth_topic},
                         skip_bad);
           }),
           py::arg("path"), py::kw_only(), py::arg("kind") = "automatic", py::arg("sensor") = "",
           py::arg("camera_file") = "", py::arg("first") = 0, py::arg("count") = -1, py::arg("stride") = 1,
           py::arg("topic") = "", py::arg("right_topic") = "", py::arg("depth_topic") = "", py::arg("skip_bad") = false)
      .def("picture", &picture_array, py::arg("frame"),
           "The image of the frame with this index as recorded, uint8: (height, width, 3), red, green, blue, or "
           "(height, width).")
      .def_property_readonly(
          "camera", [](const PyRecording& r) { return to_parameters(r.sequence->camera()); },
          "The Camera of its images, with the readout that its camera file has.")
      .def_property_readonly(
          "sensor", [](const PyRecording& r) { return public_sensor(r.sequence->sensor()); }, "The Sensor.")
      .def_property_readonly(
          "frame_rate", [](const PyRecording& r) { return r.sequence->frame_rate(); }, "Frames a second.")
      .def_property_readonly(
          "description", [](const PyRecording& r) { return text_of(r.sequence->description()); },
          "A line for people: its kind and size.")
      .def_property_readonly(
          "notes",
          [](const PyRecording& r) {
            py::list notes;
            for (const std::string& note : r.sequence->notes()) notes.append(text_of(note));
            return notes;
          },
          "List of sentences: what was skipped, and what lacked.")
      .def(
          "truth",
          [](const PyRecording& r) -> std::optional<PyTrajectory> {
            if (!r.sequence->truth()) return std::nullopt;
            return PyTrajectory::of(value(io::load_truth(*r.sequence)));
          },
          "The true trajectory; None where there is none.")
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__", &next_frame)
      .def_property_readonly(
          "unreadable", [](const PyRecording& r) { return r.unreadable.load(); },
          "Number of frames that could not be read so far.");
}

}  // namespace covis::python
