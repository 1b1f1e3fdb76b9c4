// SPDX-License-Identifier: Apache-2.0
// The snapshot of a map in Python: its lists of structs as columns, which are views and keep the snapshot alive.
#include <pybind11/stl.h>

#include "arrays.h"

namespace covis::python {

void bind_snapshot(py::module_& m) {
  using S = MapSnapshot;
  const auto column = [](auto list, size_t columns, auto member) {
    return [=](const py::object& self) { return column_of(self.cast<const S&>().*list, columns, member, self); };
  };
  py::class_<S::Submap>(m, "Submap", "A map of its own within the whole.")
      .def_readonly("id", &S::Submap::id, "Its id.")
      .def_readonly("loaded", &S::Submap::loaded, "It came from a file, or was joined to one that did.")
      .def_readonly("frames", &S::Submap::frames, "Number of frames that have a pose in it.")
      .def_readonly("key_frames", &S::Submap::key_frames, "Number of its key frames.")
      .def_readonly("points", &S::Submap::points, "Number of its points.");
  py::class_<S, std::shared_ptr<S>>(m, "Snapshot",
                                    "The map and the trajectory at one moment. Arrays are views that can't be written.")
      .def_readonly("revision", &S::revision, "Rises when the map or the trajectory changes.")
      .def_readonly("camera", &S::camera, "The Camera in use then.")
      .def_readonly("cameras", &S::cameras,
                    "List of Camera, of those that made key frames: first the one in use, then those of a map that was "
                    "continued with another camera, or merged from maps of several.")
      .def_readonly("submaps", &S::submaps, "List of Submap: loaded ones first, then those with more frames.")
      .def_property_readonly("points", column(&S::points, 3, COVIS_MEMBER(x)), "(n, 3), float64: metres.")
      .def_property_readonly("point_ids", column(&S::points, 0, COVIS_MEMBER(id)), "(n), uint64: ids of this run.")
      .def_property_readonly("point_submaps", column(&S::points, 0, COVIS_MEMBER(submap)),
                             "(n), int32: ids of the points' submaps.")
      .def_property_readonly("point_colours", column(&S::points, 3, COVIS_MEMBER(colour[0])),
                             "(n, 3), uint8: red, green, blue; NO_COLOUR where no image came with colours.")
      .def_property_readonly("key_frame_ids", column(&S::key_frames, 0, COVIS_MEMBER(id)),
                             "(n), uint64: count key frames as they are made; a saved map keeps them.")
      .def_property_readonly("key_frame_stamps", column(&S::key_frames, 0, COVIS_MEMBER(stamp)),
                             "(n), int64: nanoseconds.")
      .def_property_readonly("key_frame_frames", column(&S::key_frames, 0, COVIS_MEMBER(frame)),
                             "(n), int64: numbers of their frames, from 0.")
      .def_property_readonly("key_frame_submaps", column(&S::key_frames, 0, COVIS_MEMBER(submap)),
                             "(n), int32: ids of their submaps.")
      .def_property_readonly("key_frame_parents", column(&S::key_frames, 0, COVIS_MEMBER(parent)),
                             "(n), int64: indices of key frames in the spanning tree; -1 for a root.")
      .def_property_readonly("key_frame_cameras", column(&S::key_frames, 0, COVIS_MEMBER(camera)),
                             "(n), int32: indices into `cameras`.")
      .def_property_readonly("key_frame_positions", column(&S::key_frames, 3, COVIS_MEMBER(pose.x)),
                             "(n, 3), float64: metres.")
      .def_property_readonly("key_frame_quaternions", column(&S::key_frames, 4, COVIS_MEMBER(pose.qx)),
                             "(n, 4), float64: x y z w.")
      .def_property_readonly("edges", column(&S::edges, 2, COVIS_MEMBER(a)),
                             "(n, 2), uint32: indices of two key frames, the lesser first.")
      .def_property_readonly("edge_shared", column(&S::edges, 0, COVIS_MEMBER(shared)),
                             "(n), int32: numbers of points that both key frames observe.")
      .def_property_readonly("edge_loops", column(&S::edges, 0, COVIS_MEMBER(loop)),
                             "(n), bool: a loop was closed between the two.")
      .def_property_readonly("observations", column(&S::observations, 2, COVIS_MEMBER(key_frame)),
                             "(n, 2), uint32: indices of a key frame and a point that it observes.")
      .def_property_readonly(
          "observation_pixels", column(&S::observations, 2, COVIS_MEMBER(u)),
          "(n, 2), float32: pixels of the key frame's image as given, or as rectified here, which its "
          "camera took.")
      .def_property_readonly("stamps", column(&S::trajectory, 0, COVIS_MEMBER(stamp)),
                             "(n), int64: nanoseconds; rising, of the frames that have a pose.")
      .def_property_readonly("positions", column(&S::trajectory, 3, COVIS_MEMBER(pose.x)),
                             "(n, 3), float64: those frames' places, metres.")
      .def_property_readonly("quaternions", column(&S::trajectory, 4, COVIS_MEMBER(pose.qx)),
                             "(n, 4), float64: those frames' turns, x y z w.")
      .def_property_readonly("trajectory_submaps", column(&S::trajectory, 0, COVIS_MEMBER(submap)),
                             "(n), int32: ids of the submaps whose worlds the poses are in.");
}

}  // namespace covis::python
