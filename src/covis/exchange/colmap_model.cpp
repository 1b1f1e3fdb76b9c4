// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/colmap_model.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>

#include "covis/exchange/scene.h"
#include "covis/io/files.h"

namespace covis::exchange {
namespace {

namespace fs = std::filesystem;

// The lines of a file but for comments, with their numbers.
class Lines {
 public:
  static Result<Lines> open(const fs::path& file) {
    const auto head = io::read_head(file, 2);
    if (!head) return tl::unexpected(head.error());
    if (io::is_wide_text(*head)) return tl::unexpected(io::wide_text(file));
    return Lines(file);
  }
  std::optional<std::istringstream> next() {
    for (std::string line; std::getline(stream_, line);) {
      if (++number_ == 1) io::remove_byte_order_mark(line);
      if (line.ends_with('\r')) line.pop_back();
      if (!line.starts_with("#")) return std::istringstream(line);
    }
    return std::nullopt;
  }
  tl::unexpected<Error> problem(const std::string& what) const {
    return fail(file_.string() + ":" + std::to_string(number_) + ": " + what);
  }

 private:
  explicit Lines(const fs::path& file) : file_(file), stream_(file) {}

  fs::path file_;
  std::ifstream stream_;  // a model can be larger than what is read whole
  int number_ = 0;
};

struct Figures {
  int count;       // after the image size
  bool one_focal;  // f, cx, cy instead of fx, fy, cx, cy
  Distortion lens;
};
const std::map<std::string, Figures> kModels{{"SIMPLE_PINHOLE", {3, true, Distortion::none}},
                                             {"PINHOLE", {4, false, Distortion::none}},
                                             {"SIMPLE_RADIAL", {4, true, Distortion::brown_conrady}},
                                             {"RADIAL", {5, true, Distortion::brown_conrady}},
                                             {"OPENCV", {8, false, Distortion::brown_conrady}},
                                             {"OPENCV_FISHEYE", {8, false, Distortion::kannala_brandt}}};

constexpr int kMaxSide = 32768;  // pixels

Result<Camera> read_camera(const fs::path& file, int& id) {
  auto lines = Lines::open(file);
  if (!lines) return tl::unexpected(lines.error());
  auto line = lines->next();
  if (!line) return lines->problem("there is no camera");
  std::string model;
  Camera camera;
  *line >> id >> model >> camera.width >> camera.height;
  const auto known = kModels.find(model);
  if (!*line) return lines->problem("CAMERA_ID MODEL WIDTH HEIGHT and the model's figures are wanted, decimal numbers");
  if (known == kModels.end()) {
    return lines->problem("camera model '" + model +
                          "' is none of SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE");
  }
  const Figures& figures = known->second;
  std::array<double, 8> values{};
  for (int i = 0; i < figures.count; ++i) *line >> values[static_cast<size_t>(i)];
  const auto first = static_cast<size_t>(figures.one_focal ? 1 : 2);  // of cx, cy and the lens
  camera.pinhole = {values[0], values[first - 1], values[first] - kPixelCentre, values[first + 1] - kPixelCentre, 0};
  camera.distortion = figures.lens;
  for (size_t i = first + 2; i < static_cast<size_t>(figures.count); ++i)
    camera.coefficients[i - first - 2] = values[i];
  const Pinhole& p = camera.pinhole;
  const bool whole = *line && (*line >> std::ws).eof();
  const bool bounded = std::all_of(values.begin(), values.end(), [](double v) { return std::abs(v) < 1e6; });
  if (!whole || !bounded || std::min(camera.width, camera.height) < 64 ||
      std::max(camera.width, camera.height) > kMaxSide || !(p.fx >= 1 && p.fy >= 1) || !std::isfinite(p.fx + p.fy) ||
      !(p.cx > 0 && p.cx < camera.width && p.cy > 0 && p.cy < camera.height))
    return lines->problem("a " + model +
                          " of at least 64 x 64 and at most 32768 x 32768 pixels with positive focal lengths of a "
                          "pixel or more and its principal point "
                          "in the image is wanted");
  if (lines->next()) return lines->problem("there is a second camera; one is wanted");
  return camera;
}

Result<ColmapModel::Image> read_image(Lines& lines, std::istringstream& line, int camera, int& id) {
  ColmapModel::Image image;
  double w, x, y, z;
  Eigen::Vector3d t;
  int of_camera = 0;
  line >> id >> w >> x >> y >> z >> t.x() >> t.y() >> t.z() >> of_camera >> std::ws;
  const Eigen::Quaterniond q(w, x, y, z);
  if (!line || !std::getline(line, image.name) || !(t.cwiseAbs().maxCoeff() < 1e9) || !(std::abs(q.norm() - 1) < 1e-3))
    return lines.problem("an image's id, unit quaternion, translation, camera and name are wanted");
  if (of_camera != camera) return lines.problem("the image is of a camera that cameras.txt does not have");
  image.T_cw = SE3(q.normalized().toRotationMatrix(), t);
  const fs::path path(image.name);
  if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end())
    return lines.problem("the image " + image.name + " lies outside the folder of images");
  auto points = lines.next();
  if (!points) return lines.problem("the line with the points of image " + image.name + " is missing");
  double u, v;
  int64_t point;
  while (!(*points >> std::ws).eof()) {
    if (!(*points >> u >> v >> point))
      return lines.problem("x, y and the point's id are wanted for each point of an image");
    if (point >= 0) image.points.push_back(point);
  }
  std::sort(image.points.begin(), image.points.end());
  return image;
}

}  // namespace

Result<Camera> read_colmap_camera(const fs::path& file) {
  int id = 0;
  return read_camera(file, id);
}

Result<ColmapModel> read_colmap(const fs::path& folder) {
  if (fs::exists(folder / "cameras.bin") && !fs::exists(folder / "cameras.txt")) {
    return fail(folder.string() +
                ": the model is binary; make it a text: colmap model_converter --input_path FOLDER --output_path NEW "
                "--output_type TXT");
  }
  for (const char* name : {"cameras.txt", "images.txt"}) {
    if (!fs::is_regular_file(folder / name)) return fail((folder / name).string() + ": there is no such file");
  }
  int id = 0;
  auto camera = read_camera(folder / "cameras.txt", id);
  if (!camera) return tl::unexpected(camera.error());
  ColmapModel model{.camera = *camera, .images = {}};
  std::map<int, ColmapModel::Image> by_id;
  auto lines = Lines::open(folder / "images.txt");
  if (!lines) return tl::unexpected(lines.error());
  while (auto line = lines->next()) {
    if (line->str().empty()) continue;
    int image_id = 0;
    auto image = read_image(*lines, *line, id, image_id);
    if (!image) return tl::unexpected(image.error());
    if (!by_id.emplace(image_id, std::move(*image)).second)
      return lines->problem("there is another image of the id " + std::to_string(image_id));
  }
  for (auto& [number, image] : by_id) model.images.push_back(std::move(image));
  if (model.images.size() < 2) return fail((folder / "images.txt").string() + ": there are less than two images");
  return model;
}

}  // namespace covis::exchange
