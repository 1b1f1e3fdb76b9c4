// SPDX-License-Identifier: Apache-2.0
// NumPy arrays as images and back, without copies.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "covis/core/image.h"
#include "covis/covis.h"

namespace covis::python {

namespace py = pybind11;

// The image of an array of pixels, which must live as long as it. Raises TypeError for another dtype, ValueError for
// another shape or for rows that are not contiguous: nothing is copied behind the caller's back.
template <class Image, class Pixel>
Image to_image(const py::object& object, const char* which, const char* wanted) {
  if (!py::isinstance<py::array>(object))
    throw py::type_error(std::string(which) + ": a NumPy array is wanted, not " +
                         std::string(py::str(py::type::of(object))));
  const auto array = py::reinterpret_borrow<py::array>(object);
  if (!py::isinstance<py::array_t<Pixel>>(object))
    throw py::type_error(std::string(which) + ": dtype " + wanted + " is wanted, not " +
                         std::string(py::str(array.dtype())));
  if (array.ndim() != 2)
    throw py::value_error(std::string(which) + ": a shape (height, width) is wanted, not one of " +
                          std::to_string(array.ndim()) + " dimensions");
  constexpr auto kSize = static_cast<py::ssize_t>(sizeof(Pixel));
  if ((array.shape(1) > 1 && array.strides(1) != kSize) || array.strides(0) % kSize != 0 || array.strides(0) < 0)
    throw py::value_error(std::string(which) +
                          ": rows must be contiguous and in order; numpy.ascontiguousarray() makes them so");
  constexpr py::ssize_t kGreatest = std::numeric_limits<int>::max();
  if (array.shape(0) > kGreatest || array.shape(1) > kGreatest)
    throw py::value_error(std::string(which) + ": more than " + std::to_string(kGreatest) + " rows or columns");
  Image image;
  image.data = static_cast<const Pixel*>(array.data());
  image.width = static_cast<int>(array.shape(1));
  image.height = static_cast<int>(array.shape(0));
  image.stride = array.strides(0) / kSize;
  return image;
}

inline GreyImage to_grey(const py::object& object, const char* which) {
  return to_image<GreyImage, uint8_t>(object, which, "uint8");
}
// Red, green and blue of each pixel, or blue first.
inline ColourImage to_colour(const py::object& object, ColourOrder order) {
  if (!py::isinstance<py::array_t<uint8_t>>(object)) throw py::type_error("colour: a NumPy array of uint8 is wanted");
  const auto array = py::reinterpret_borrow<py::array>(object);
  if (array.ndim() != 3 || array.shape(2) != 3) throw py::value_error("colour: a shape (height, width, 3) is wanted");
  if (array.strides(2) != 1 || array.strides(1) != 3 || array.strides(0) < 0)
    throw py::value_error("colour: rows must be contiguous and in order; numpy.ascontiguousarray() makes them so");
  return {static_cast<const uint8_t*>(array.data()), static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)),
          array.strides(0), order};
}
inline DepthImage to_depth(const py::object& object) { return to_image<DepthImage, float>(object, "depth", "float32"); }

// An array that can't be written, of `owner`'s memory: `count` rows of `columns` values, each row `stride` bytes after
// the one before.
template <class T>
py::array_t<T> view_of(const T* first, size_t count, size_t columns, size_t stride, const py::handle& owner) {
  const std::vector<size_t> shape = columns > 0 ? std::vector<size_t>{count, columns} : std::vector<size_t>{count};
  const std::vector<size_t> strides =
      columns > 0 ? std::vector<size_t>{stride, sizeof(T)} : std::vector<size_t>{stride};
  py::array_t<T> array(shape, strides, first, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

// A function that returns a member of its argument.
#define COVIS_MEMBER(path) \
  [](auto& entry) -> auto& { return entry.path; }

// A column of a list of structs: member(list[k]) is the first of `columns` values.
template <class List, class Member>
auto column_of(const List& list, size_t columns, const Member& member, const py::handle& owner) {
  using T = std::remove_cvref_t<decltype(member(list[0]))>;
  return view_of<T>(list.empty() ? nullptr : &member(list[0]), list.size(), columns, sizeof(list[0]), owner);
}

// The 4 x 4 matrix of a pose, camera to world.
inline py::array_t<double> matrix_of(const Pose& p) {
  py::array_t<double> m({4, 4});
  auto r = m.mutable_unchecked<2>();
  const double x = p.qx, y = p.qy, z = p.qz, w = p.qw;
  const double rows[4][4] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), p.x},
                             {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), p.y},
                             {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), p.z},
                             {0, 0, 0, 1}};
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) r(i, k) = rows[i][k];
  }
  return m;
}

// A text that may name a file whose name is not of UTF-8; its other bytes become \\x and two digits.
inline py::str text_of(std::string_view text) {
  PyObject* decoded = PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "backslashreplace");
  if (decoded == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(decoded);
}

// A tl::expected's value; its error is raised as covis.Error.
struct CovisError : std::runtime_error {
  using std::runtime_error::runtime_error;
};
template <class T>
T value_of(tl::expected<T, std::string> result) {
  if (!result) throw CovisError(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

void bind_values(py::module_& module);
void bind_snapshot(py::module_& module);
void bind_recordings(py::module_& module);

}  // namespace covis::python
