// SPDX-License-Identifier: Apache-2.0
// Folders of images and depth images with equal names, as Open3D's recorders of RealSense and Azure Kinect cameras make
// them: color/ (or rgb/, image/), depth/, camera_intrinsic.json. Source: Open3D's documentation, open3d.org/docs,
// "Sensors".
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "covis/io/bad_frames.h"
#include "covis/io/files.h"
#include "covis/io/image_stamps.h"
#include "covis/io/open3d_camera.h"
#include "covis/io/recording.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

// The folder of colour images; empty: there is none.
fs::path colour_folder(const fs::path& folder) {
  for (const char* name : {"color", "rgb", "image"}) {
    if (!list_images(folder / name).empty()) return folder / name;
  }
  return {};
}

Result<CameraFile> find_open3d_camera(const Request& request) {
  if (request.given) return *request.given;
  if (fs::exists(request.folder / "camera.yaml")) return load_camera(request.folder / "camera.yaml");
  for (const char* name : {"camera_intrinsic.json", "intrinsic.json"}) {
    CameraFile found;
    found.file = request.folder / name;
    if (!fs::exists(found.file)) continue;
    const auto camera = read_open3d_camera(found.file);
    if (!camera) return tl::unexpected(camera.error());
    found.camera = *camera;
    return found;
  }
  return tl::unexpected(no_calibration(request.folder, "camera.yaml, camera_intrinsic.json"));
}

// Gives each frame the depth image of its name, and drops frames that have none.
Result<void> add_depth(const fs::path& depth_folder, Recording& recording) {
  std::map<std::string, fs::path> depths;
  for (const fs::path& depth : list_images(depth_folder)) depths[depth.stem().string()] = depth;
  const size_t all = recording.frames.size();
  std::erase_if(recording.frames, [&](FrameFiles& frame) {
    const auto depth = depths.find(fs::path(frame.image).stem().string());
    if (depth != depths.end()) frame.depth = depth->second.string();
    return depth == depths.end();
  });
  if (recording.frames.empty()) return fail(depth_folder.string() + ": no depth image in it has the name of an image");
  if (const size_t left_out = all - recording.frames.size(); left_out > 0)
    note_left_out(left_out, all, "images have no depth image of their name", recording);
  return {};
}

// The object that the file holds. Of a key that is given twice the library would take the last value.
Result<nlohmann::json> read_object(const fs::path& file) {
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  std::vector<std::set<std::string>> open;  // the keys of the objects around the present place
  std::string twice;
  const auto note = [&](int, nlohmann::json::parse_event_t event, const nlohmann::json& parsed) {
    using Event = nlohmann::json::parse_event_t;
    if (event == Event::object_start) open.emplace_back();
    if (event == Event::object_end) open.pop_back();
    if (event == Event::key && !open.back().insert(parsed.get<std::string>()).second) twice = parsed.get<std::string>();
    return true;
  };
  nlohmann::json root = nlohmann::json::parse(*text, note, false);
  if (root.is_discarded() || !root.is_object()) return fail(file.string() + ": it is not JSON, or no object");
  if (!twice.empty()) return fail(file.string() + ": '" + twice + "' is given twice");
  return root;
}

}  // namespace

Result<Camera> read_open3d_camera(const fs::path& file) {
  const auto root = read_object(file);
  if (!root) return tl::unexpected(root.error());
  Camera camera;
  for (const auto& [key, side] : {std::pair("width", &camera.width), {"height", &camera.height}}) {
    const auto found = root->find(key);
    if (found == root->end() || !found->is_number_integer() || *found < 1 || *found > 20000)
      return fail(file.string() + ": '" + key + "' must be that of the images, in pixels");
    *side = found->get<int>();
  }
  const auto matrix = root->find("intrinsic_matrix");
  const bool numbers = matrix != root->end() && matrix->is_array() && matrix->size() == 9 &&
                       std::all_of(matrix->begin(), matrix->end(), [](const auto& v) { return v.is_number(); });
  if (!numbers) return fail(file.string() + ": 'intrinsic_matrix' must be a list of nine numbers");
  const auto k = matrix->get<std::vector<double>>();
  if (k[1] != 0 || k[2] != 0 || k[3] != 0 || k[5] != 0 || k[8] != 1 || !(k[0] > 0) || !(k[4] > 0)) {
    return fail(file.string() +
                ": intrinsic_matrix must hold fx 0 0 0 fy 0 cx cy 1 (its columns one after the other), with positive "
                "focal lengths");
  }
  camera.pinhole = {k[0], k[4], k[6], k[7], 0};
  return camera;
}

// Folders of images may hold pictures of depth, or depth of other moments, beside the images.
bool is_open3d(const fs::path& folder) {
  const fs::path colour = colour_folder(folder), depth = folder / "depth";
  if (colour.empty() || list_images(depth).empty()) return false;
  if (colour.filename() == "color" || fs::exists(folder / "camera_intrinsic.json")) return true;
  const std::vector<fs::path> images = list_images(colour);
  const auto matching = std::count_if(images.begin(), images.end(), [&](const fs::path& image) {
    return fs::exists(depth / (image.stem().string() + ".png"));
  });
  return 2 * static_cast<size_t>(matching) >= images.size();
}

Result<Recording> read_open3d(const Request& request) {
  const fs::path& folder = request.folder;
  if (!is_open3d(folder) && has_pairs(folder)) return read_pairs(request);
  Recording recording;
  recording.kind = SequenceKind::open3d;
  recording.name = "RGB-D image folder";
  const fs::path colour = colour_folder(folder);
  if (colour.empty()) return fail(folder.string() + ": there is no image in color, rgb or image");
  const bool has_depth = !list_images(folder / "depth").empty();
  recording.sensor = request.wanted.value_or(has_depth ? Sensor::rgbd : Sensor::monocular);
  if (recording.sensor == Sensor::stereo)
    return fail(folder.string() + ": an RGB-D image folder has no stereo pairs; --sensor must be rgbd or mono");
  if (recording.sensor == Sensor::rgbd && !has_depth)
    return fail((folder / "depth").string() + ": there is no depth image in it; without depth use --sensor mono");
  const auto camera = find_open3d_camera(request);
  if (!camera) return tl::unexpected(camera.error());
  take_camera(*camera, 1000, recording);
  const std::vector<fs::path> images = list_images(colour);
  const auto stamps = stamps_of_images(folder, colour, images, camera->fps, recording.notes);
  if (!stamps) return tl::unexpected(stamps.error());
  for (size_t i = 0; i < images.size(); ++i) recording.frames.push_back({(*stamps)[i], images[i], {}, {}});
  if (recording.sensor == Sensor::rgbd) {
    if (auto added = add_depth(folder / "depth", recording); !added) return tl::unexpected(added.error());
  }
  if (fs::exists(folder / "groundtruth.txt")) recording.truth = Truth{folder / "groundtruth.txt", {}};
  return recording;
}

}  // namespace covis::io
