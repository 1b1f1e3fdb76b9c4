// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/colmap_model.h"

#include <Eigen/Core>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "covis/exchange/colmap_parts.h"
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

Result<Camera> read_camera(const fs::path& file, int& id) {
  auto lines = Lines::open(file);
  if (!lines) return tl::unexpected(lines.error());
  auto line = lines->next();
  if (!line) return lines->problem("there is no camera");
  std::string model;
  int64_t width = 0, height = 0;
  *line >> id >> model >> width >> height;
  if (!*line) return lines->problem("CAMERA_ID MODEL WIDTH HEIGHT and the model's figures are wanted, decimal numbers");
  const auto figures = colmap_figures(model);
  if (!figures) return lines->problem(unknown_colmap_model(model).message);
  std::vector<double> values(*figures);
  for (double& value : values) *line >> value;
  const bool whole = *line && (*line >> std::ws).eof();
  if (!whole) values.assign(*figures, 0);
  auto camera = colmap_camera(model, width, height, values);
  if (!camera) return lines->problem(camera.error().message);
  while (auto more = lines->next()) {
    if (!(*more >> std::ws).eof()) return lines->problem("there is a second camera; " + std::string(kOneCameraWanted));
  }
  return camera;
}

Result<ColmapModel::Image> read_image(Lines& lines, std::istringstream& line, int camera, int& id) {
  Eigen::Vector4d q = Eigen::Vector4d::Zero();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  std::string name;
  int of_camera = 0;
  line >> id >> q[0] >> q[1] >> q[2] >> q[3] >> t[0] >> t[1] >> t[2] >> of_camera >> std::ws;
  if (!line || !std::getline(line, name)) q.setZero();
  auto image = colmap_image(name, q, t);
  if (!image) return lines.problem(image.error().message);
  if (of_camera != camera) return lines.problem("the image is of a camera that cameras.txt does not have");
  auto points = lines.next();
  if (!points) return lines.problem("the line with the points of image " + name + " is missing");
  double u, v;
  int64_t point;
  while (!(*points >> std::ws).eof()) {
    if (!(*points >> u >> v >> point))
      return lines.problem("x, y and the point's id are wanted for each point of an image");
    if (point >= 0) image->points.push_back(point);
  }
  return image;
}

}  // namespace

Result<Camera> read_colmap_camera(const fs::path& file) {
  if (file.extension() == ".bin") {
    uint32_t id = 0;
    return read_colmap_binary_camera(file, id);
  }
  int id = 0;
  return read_camera(file, id);
}

Result<ColmapModel> read_colmap(const fs::path& folder) {
  const bool binary = fs::exists(folder / "cameras.bin") && !fs::exists(folder / "cameras.txt");
  for (const std::string name : {"cameras", "images"}) {
    const fs::path file = folder / (name + (binary ? ".bin" : ".txt"));
    if (!fs::is_regular_file(file)) return fail(file.string() + ": there is no such file");
  }
  if (binary) return read_colmap_binary(folder);
  int id = 0;
  const auto camera = read_camera(folder / "cameras.txt", id);
  if (!camera) return tl::unexpected(camera.error());
  std::map<int64_t, ColmapModel::Image> by_id;
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
  return colmap_model(*camera, std::move(by_id), folder / "images.txt");
}

}  // namespace covis::exchange
