// SPDX-License-Identifier: Apache-2.0
// COLMAP's documentation of its output format, binary: little endian, without gaps.
#include <algorithm>
#include <bit>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>
#include <vector>

#include "covis/exchange/colmap_parts.h"

namespace covis::exchange {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "Bytes copies numbers as they are");

// The names stand in the order of their numbers.
constexpr const char* kModelNames[] = {"SIMPLE_PINHOLE",
                                       "PINHOLE",
                                       "SIMPLE_RADIAL",
                                       "RADIAL",
                                       "OPENCV",
                                       "OPENCV_FISHEYE",
                                       "FULL_OPENCV",
                                       "FOV",
                                       "SIMPLE_RADIAL_FISHEYE",
                                       "RADIAL_FISHEYE",
                                       "THIN_PRISM_FISHEYE"};

constexpr uint64_t kCameraBytes = 4 + 4 + 8 + 8;         // without its figures
constexpr uint64_t kImageBytes = 4 + 7 * 8 + 4 + 1 + 8;  // without its name and points
constexpr uint64_t kPointBytes = 8 + 8 + 8;
constexpr size_t kLongestName = 4096;

// The bytes of a file in their order, no more than it had when it was opened.
class Bytes {
 public:
  static Result<Bytes> open(const fs::path& file) {
    std::error_code error;
    const uint64_t size = fs::file_size(file, error);
    Bytes bytes(file, size);
    if (error || !bytes.stream_) return fail(file.string() + ": it can't be read");
    return bytes;
  }
  uint64_t left() const { return left_; }
  template <class Number>
  bool read(Number& number) {
    if (left_ < sizeof number || !stream_.read(reinterpret_cast<char*>(&number), sizeof number)) return false;
    left_ -= sizeof number;
    return true;
  }
  // Reads up to the zero behind it.
  bool read(std::string& name) {
    name.clear();
    for (char c = 0; name.size() < kLongestName && read(c); name += c) {
      if (c == 0) return true;
    }
    return false;
  }
  // Reads a number of things that have so many bytes each, or more.
  bool read_count(uint64_t& count, uint64_t least) { return read(count) && count <= left_ / least; }
  tl::unexpected<Error> problem(const std::string& what) const { return fail(file_.string() + ": " + what); }
  tl::unexpected<Error> cut(const std::string& where) const {
    return problem(where + ", " + std::to_string(size_) +
                   " bytes are fewer than its counts say: the file is cut off, or no binary model of COLMAP");
  }

 private:
  Bytes(const fs::path& file, uint64_t size) : file_(file), stream_(file, std::ios::binary), size_(size), left_(size) {}

  fs::path file_;
  std::ifstream stream_;
  uint64_t size_, left_;
};

bool read_points(Bytes& bytes, std::vector<int64_t>& points) {
  uint64_t count = 0;
  if (!bytes.read_count(count, kPointBytes)) return false;
  for (uint64_t k = 0; k < count; ++k) {
    double u = 0, v = 0;
    int64_t point = -1;  // the greatest number without a sign says that there is none
    if (!bytes.read(u) || !bytes.read(v) || !bytes.read(point)) return false;
    if (point >= 0) points.push_back(point);
  }
  return true;
}

}  // namespace

Result<Camera> read_colmap_binary_camera(const fs::path& file, uint32_t& id) {
  auto bytes = Bytes::open(file);
  if (!bytes) return tl::unexpected(bytes.error());
  uint64_t count = 0, width = 0, height = 0;
  int32_t model = 0;
  if (!bytes->read_count(count, kCameraBytes)) return bytes->cut("at the number of cameras");
  if (count == 0) return bytes->problem("there is no camera");
  if (count > 1) return bytes->problem("there are " + std::to_string(count) + " cameras; " + kOneCameraWanted);
  if (!bytes->read(id) || !bytes->read(model) || !bytes->read(width) || !bytes->read(height))
    return bytes->cut("at the camera");
  const bool named = model >= 0 && static_cast<size_t>(model) < std::size(kModelNames);
  const std::string name = named ? kModelNames[model] : std::to_string(model);
  const auto figures = colmap_figures(name);
  if (!figures) return bytes->problem(unknown_colmap_model(name).message);
  std::vector<double> values(*figures);
  for (double& value : values) {
    if (!bytes->read(value)) return bytes->cut("at the camera");
  }
  if (bytes->left() > 0) return bytes->problem("there are bytes behind the camera; one camera is wanted");
  constexpr uint64_t kMost = 1'000'000'000;
  auto camera = colmap_camera(name, static_cast<int64_t>(std::min(width, kMost)),
                              static_cast<int64_t>(std::min(height, kMost)), values);
  if (!camera) return bytes->problem(camera.error().message);
  return camera;
}

Result<ColmapModel> read_colmap_binary(const fs::path& folder) {
  uint32_t camera_id = 0;
  const auto camera = read_colmap_binary_camera(folder / "cameras.bin", camera_id);
  if (!camera) return tl::unexpected(camera.error());
  auto bytes = Bytes::open(folder / "images.bin");
  if (!bytes) return tl::unexpected(bytes.error());
  uint64_t count = 0;
  if (!bytes->read_count(count, kImageBytes)) return bytes->cut("at the number of images");
  std::map<int64_t, ColmapModel::Image> by_id;
  for (uint64_t k = 0; k < count; ++k) {
    const std::string where = "image " + std::to_string(k + 1) + " of " + std::to_string(count);
    uint32_t id = 0, of_camera = 0;
    Eigen::Vector4d q;
    Eigen::Vector3d t;
    std::string name;
    bool whole = bytes->read(id);
    for (double& value : q) whole = whole && bytes->read(value);
    for (double& value : t) whole = whole && bytes->read(value);
    if (!whole || !bytes->read(of_camera) || !bytes->read(name)) return bytes->cut("at " + where);
    auto image = colmap_image(name, q, t);
    if (!image) return bytes->problem(where + ": " + image.error().message);
    if (of_camera != camera_id)
      return bytes->problem(where + ": the image is of a camera that cameras.bin does not have");
    if (!read_points(*bytes, image->points)) return bytes->cut("at the points of " + where);
    if (!by_id.emplace(id, std::move(*image)).second)
      return bytes->problem(where + ": there is another image of the id " + std::to_string(id));
  }
  if (bytes->left() > 0) return bytes->problem("there are bytes behind the last image");
  return colmap_model(*camera, std::move(by_id), folder / "images.bin");
}

}  // namespace covis::exchange
