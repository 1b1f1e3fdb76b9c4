// SPDX-License-Identifier: Apache-2.0
#include "covis/io/camera_file.h"

#include <map>
#include <sstream>
#include <tuple>

#include "covis/core/fields.h"
#include "covis/geometry/camera_check.h"
#include "covis/io/files.h"
#include "covis/io/yaml.h"

namespace covis::io {
namespace {

const std::map<std::string, Distortion> kModels{{"pinhole", Distortion::none},
                                                {"brown_conrady", Distortion::brown_conrady},
                                                {"kannala_brandt", Distortion::kannala_brandt}};

const std::map<std::string, DepthNoise> kDepthNoises{
    {"kinect", DepthNoise::kinect()}, {"realsense", DepthNoise::realsense()}, {"exact", DepthNoise::exact()}};

const char* model_name(Distortion distortion) {
  for (const auto& [model, value] : kModels) {
    if (value == distortion) return model.c_str();
  }
  return "";
}

// The scalar values of the file; model and distortion are read separately.
struct Values {
  int width = 0, height = 0, bits = 16;
  double fx = 0, fy = 0, cx = 0, cy = 0, baseline = 0, bf = 0, fps = 0, depth_scale = 0, depth_sigma_a = 0,
         depth_sigma_b = 0, readout = 0;
  double depth_fx = 0, depth_cx = 0, depth_cy = 0, depth_x = 0, depth_y = 0;
  std::string model = "pinhole", depth_noise;

  Fields fields() {
    using B = CameraBounds;
    return {{"width", &width, "width of the image, pixels", B::kLeastSide, B::kLargestSide},
            {"height", &height, "height of the image, pixels", B::kLeastSide, B::kLargestSide},
            {"fx", &fx, "focal length, pixels", B::kLeastFocal, B::kLargestFocal},
            {"fy", &fy, "focal length, pixels", B::kLeastFocal, B::kLargestFocal},
            {"cx", &cx, "principal point, pixels", 0, B::kLargestSide},
            {"cy", &cy, "principal point, pixels", 0, B::kLargestSide},
            {"baseline", &baseline, "baseline of the stereo pair, metres", B::kLeastBaseline, B::kLargestBaseline},
            {"bf", &bf, "baseline times fx, pixels x metres", 1e-3, 1e6},
            {"fps", &fps, "frames per second", 0.01, 10000},
            {"readout", &readout, "rolling shutter: seconds from the first row to the last", -B::kLongestReadout,
             B::kLongestReadout},
            {"depth_scale", &depth_scale, "units of a depth image per metre", 1e-3, 1e6},
            {"bits", &bits, "of images of 16 bits: how many their camera fills, the lowest ones", 8, 16},
            {"depth_sigma_a", &depth_sigma_a, "noise of a depth z: sigma = a + b z^2; a in metres", 0, 1},
            {"depth_sigma_b", &depth_sigma_b, "the same; b in 1 / metres", 0, 1},
            {"depth_fx", &depth_fx, "focal length of depth images that are not registered, pixels", B::kLeastFocal,
             B::kLargestFocal},
            {"depth_cx", &depth_cx, "their principal point, pixels", 0, B::kLargestSide},
            {"depth_cy", &depth_cy, "their principal point, pixels", 0, B::kLargestSide},
            {"depth_x", &depth_x, "how far right of the image's camera theirs is, metres", -1, 1},
            {"depth_y", &depth_y, "how far below the image's camera theirs is, metres", -1, 1},
            {"depth_noise", &depth_noise, "kinect, realsense or exact, instead of depth_sigma_a and depth_sigma_b"},
            {"model", &model, "pinhole, brown_conrady or kannala_brandt"}};
  }
};

Result<void> read_distortion(const std::filesystem::path& file, const YAML::Node& node, Camera& camera) {
  const std::string where = yaml_place(file, node) + ": distortion";
  const size_t most = camera.distortion == Distortion::kannala_brandt ? 4 : 5;
  if (camera.distortion == Distortion::none) {
    return fail(where + " is given, but model is pinhole; it must be brown_conrady or kannala_brandt then");
  }
  if (!node.IsSequence() || node.size() < 4 || node.size() > most) {
    return fail(where +
                " must be a list: [k1, k2, p1, p2] or [k1, k2, p1, p2, k3] for brown_conrady, [k1, k2, k3, k4] for "
                "kannala_brandt");
  }
  for (size_t i = 0; i < node.size(); ++i) {
    const auto value = parse_double(node[i].Scalar());
    if (!value) return fail(where + ": '" + node[i].Scalar() + "' is not a finite number");
    camera.coefficients[i] = *value;
  }
  return {};
}

// Reads the noise of depth, by the name of a kind of sensor or by its two figures.
Result<DepthNoise> read_depth_noise(const std::filesystem::path& file, const std::map<std::string, YAML::Node>& given,
                                    const Values& values) {
  if (!given.contains("depth_noise")) {
    const DepthNoise noise{values.depth_sigma_a, values.depth_sigma_b};
    const bool told = given.contains("depth_sigma_a") || given.contains("depth_sigma_b");
    if (told && !noise.known()) return fail(file.string() + ": depth_sigma_a or depth_sigma_b must be greater than 0");
    return noise;
  }
  if (given.contains("depth_sigma_a") || given.contains("depth_sigma_b"))
    return fail(file.string() + ": give depth_noise or depth_sigma_a and depth_sigma_b, not both");
  const auto noise = kDepthNoises.find(values.depth_noise);
  if (noise != kDepthNoises.end()) return noise->second;
  return fail(yaml_place(file, given.at("depth_noise")) + ": depth_noise '" + values.depth_noise +
              "' is unknown; it must be kinect, realsense or exact");
}

// Reads where depth images show what images show, by their camera; where nothing is given they are registered.
Result<DepthRegistration> read_registration(const std::filesystem::path& file,
                                            const std::map<std::string, YAML::Node>& given, const Values& values) {
  if (!given.contains("depth_fx")) {
    for (const char* key : {"depth_cx", "depth_cy", "depth_x", "depth_y"}) {
      if (given.contains(key))
        return fail(yaml_place(file, given.at(key)) + ": " + key + " is of use with depth_fx only, which is missing");
    }
    return DepthRegistration{};
  }
  const double depth_cx = given.contains("depth_cx") ? values.depth_cx : values.cx;
  const double depth_cy = given.contains("depth_cy") ? values.depth_cy : values.cy;
  const DepthRegistration registration = registration_of(
      {values.depth_fx, depth_cx, depth_cy, values.depth_x, values.depth_y}, values.fx, values.cx, values.cy);
  if (registration.valid()) return registration;
  return fail(yaml_place(file, given.at("depth_fx")) + ": depth_fx: '" + given.at("depth_fx").Scalar() +
              "' is not right; it must be from 0.1 to 10 times fx");
}

}  // namespace

Result<CameraFile> load_camera(const std::filesystem::path& file) {
  const auto root = load_only_yaml(file);
  if (!root) return tl::unexpected(root.error());
  if (!root->IsMap()) return fail(file.string() + ": it must be a map: width, height, fx, fy, cx, cy …");
  Values values;
  Fields fields = values.fields();
  std::vector<std::string> names{"distortion"};
  for (const Field& field : fields) names.push_back(field.name);
  std::map<std::string, YAML::Node> given;
  for (const auto& entry : *root) {
    const std::string key = entry.first.Scalar(), where = yaml_place(file, entry.first);
    if (std::find(names.begin(), names.end(), key) == names.end()) {
      return fail(where + ": unknown key '" + key + "'; the nearest known one is '" + nearest_name(key, names) + "'");
    }
    given.emplace(key, entry.second);
    if (key == "distortion") continue;
    if (!entry.second.IsScalar()) return fail(where + ": '" + key + "' must be a single value");
    if (auto set = set_field(fields, key, entry.second.Scalar()); !set) return fail(where + ": " + set.error().message);
  }
  for (const char* needed : {"width", "height", "fx", "fy", "cx", "cy"}) {
    if (!given.contains(needed)) return fail(file.string() + ": '" + needed + "' is missing");
  }
  if (given.contains("baseline") && given.contains("bf"))
    return fail(file.string() + ": give baseline or bf, not both");
  const auto model = kModels.find(values.model);
  if (model == kModels.end()) {
    return fail(yaml_place(file, given["model"]) + ": model '" + values.model +
                "' is unknown; it must be pinhole, brown_conrady or kannala_brandt");
  }
  for (const auto& [key, value, size] : {std::tuple{"cx", values.cx, values.width}, {"cy", values.cy, values.height}}) {
    if (!(value > 0 && value < size)) {
      return fail(yaml_place(file, given[key]) + ": " + key + ": '" + given[key].Scalar() +
                  "' is not right; the principal point must lie inside the image of " + std::to_string(values.width) +
                  "x" + std::to_string(values.height));
    }
  }
  CameraFile result;
  result.file = file;
  result.baseline = given.contains("bf") ? values.bf / values.fx : values.baseline;
  result.fps = values.fps;
  result.depth_scale = values.depth_scale;
  result.bits = values.bits;
  result.camera.width = values.width;
  result.camera.height = values.height;
  result.camera.pinhole = {values.fx, values.fy, values.cx, values.cy, values.fx * result.baseline};
  result.camera.pinhole.row_time = values.readout / values.height;
  const auto depth_noise = read_depth_noise(file, given, values);
  if (!depth_noise) return tl::unexpected(depth_noise.error());
  result.camera.pinhole.depth_noise = *depth_noise;
  const auto registration = read_registration(file, given, values);
  if (!registration) return tl::unexpected(registration.error());
  result.camera.pinhole.registration = *registration;
  result.camera.distortion = model->second;
  if (given.contains("distortion")) {
    if (auto read = read_distortion(file, given["distortion"], result.camera); !read)
      return tl::unexpected(read.error());
  } else if (model->second != Distortion::none) {
    return fail(file.string() + ": model is " + values.model + ", but 'distortion' is missing");
  }
  if (const auto problem = problem_of(result.camera)) return fail(file.string() + ": " + *problem);
  return result;
}

std::string camera_text(const CameraFile& file) {
  const Camera& c = file.camera;
  std::ostringstream text;
  text.precision(17);
  text << "width: " << c.width << "\nheight: " << c.height << "\nfx: " << c.pinhole.fx << "\nfy: " << c.pinhole.fy
       << "\ncx: " << c.pinhole.cx << "\ncy: " << c.pinhole.cy << "\nmodel: " << model_name(c.distortion) << "\n";
  if (c.distortion != Distortion::none) {
    text << "distortion: [";
    const size_t count = c.distortion == Distortion::kannala_brandt ? 4 : 5;
    for (size_t i = 0; i < count; ++i) text << (i ? ", " : "") << c.coefficients[i];
    text << "]\n";
  }
  if (file.baseline > 0) text << "baseline: " << file.baseline << "\n";
  if (file.fps > 0) text << "fps: " << file.fps << "\n";
  if (c.pinhole.row_time != 0) text << "readout: " << c.pinhole.row_time * c.height << "\n";
  if (file.depth_scale > 0) text << "depth_scale: " << file.depth_scale << "\n";
  if (file.bits < 16) text << "bits: " << file.bits << "\n";
  if (const DepthNoise& noise = c.pinhole.depth_noise; noise.known())
    text << "depth_sigma_a: " << noise.a << "\ndepth_sigma_b: " << noise.b << "\n";
  if (const DepthRegistration& r = c.pinhole.registration; r.any()) {
    const DepthCamera depth = depth_camera_of(r, c.pinhole.fx, c.pinhole.cx, c.pinhole.cy);
    text << "depth_fx: " << depth.fx << "\ndepth_cx: " << depth.cx << "\ndepth_cy: " << depth.cy
         << "\ndepth_x: " << depth.x << "\ndepth_y: " << depth.y << "\n";
  }
  return text.str();
}

}  // namespace covis::io
