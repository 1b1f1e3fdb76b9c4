// SPDX-License-Identifier: Apache-2.0
// EuRoC sequences (Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 2016): mav0/cam0, cam1 with data.csv
// and sensor.yaml.
#include <Eigen/LU>
#include <map>

#include "covis/io/files.h"
#include "covis/io/recording.h"
#include "covis/io/yaml.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

struct Sensored {
  Camera camera;
  SE3 T_bs;  // sensor to body
};

Result<std::vector<double>> numbers(const fs::path& file, const YAML::Node& parent, const char* key, size_t least) {
  const YAML::Node node = parent[key];
  if (!node || !node.IsSequence())
    return fail(file.string() + ": '" + key + "' is missing, a list of numbers is wanted");
  std::vector<double> values;
  for (const auto& item : node) {
    const auto value = parse_double(item.Scalar());
    if (!value) return fail(yaml_place(file, item) + ": " + key + ": '" + item.Scalar() + "' is not a finite number");
    values.push_back(*value);
  }
  if (values.size() < least)
    return fail(yaml_place(file, node) + ": " + key + " needs " + std::to_string(least) + " numbers");
  return values;
}

Result<Sensored> read_sensor(const fs::path& file) {
  const auto root = load_yaml(file);
  if (!root) return tl::unexpected(root.error());
  if (!root->IsMap() || !(*root)["T_BS"]) return fail(file.string() + ": 'T_BS' is missing");
  const auto t = numbers(file, (*root)["T_BS"], "data", 16);
  if (!t) return tl::unexpected(t.error());
  const auto size = numbers(file, *root, "resolution", 2);
  if (!size) return tl::unexpected(size.error());
  const auto k = numbers(file, *root, "intrinsics", 4);
  if (!k) return tl::unexpected(k.error());
  if (!((*k)[0] > 0) || !((*k)[1] > 0)) return fail(file.string() + ": intrinsics: the focal lengths must be positive");
  Sensored sensor;
  sensor.camera.width = static_cast<int>((*size)[0]);
  sensor.camera.height = static_cast<int>((*size)[1]);
  sensor.camera.pinhole = {(*k)[0], (*k)[1], (*k)[2], (*k)[3], 0};
  const std::string model = (*root)["distortion_model"] ? (*root)["distortion_model"].Scalar() : "none";
  if (model == "radial-tangential" || model == "radtan" || model == "plumb_bob") {
    sensor.camera.distortion = Distortion::brown_conrady;
  } else if (model == "equidistant") {
    sensor.camera.distortion = Distortion::kannala_brandt;
  } else if (model != "none") {
    return fail(file.string() + ": distortion_model '" + model +
                "' is unknown; it must be radial-tangential, equidistant or none");
  }
  if (sensor.camera.distortion != Distortion::none) {
    const auto d = numbers(file, *root, "distortion_coefficients", 4);
    if (!d) return tl::unexpected(d.error());
    std::copy_n(d->begin(), std::min<size_t>(d->size(), 5), sensor.camera.coefficients.begin());
  }
  Eigen::Matrix3d R;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) R(r, c) = (*t)[static_cast<size_t>(r * 4 + c)];
  }
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-3 || R.determinant() < 0) {
    return fail(file.string() + ": T_BS does not hold a rotation");
  }
  sensor.T_bs = SE3(R, Eigen::Vector3d((*t)[3], (*t)[7], (*t)[11])).normalized();
  return sensor;
}

// Stamp to image, from data.csv or, without one, from the files' names.
Result<std::map<Timestamp, fs::path>> read_list(const fs::path& camera) {
  std::map<Timestamp, fs::path> images;
  const fs::path csv = camera / "data.csv";
  if (!fs::exists(csv)) {
    for (const fs::path& image : list_images(camera / "data")) {
      if (const auto stamp = parse_stamp(image.stem().string())) images[*stamp] = image;
    }
    if (images.empty()) return fail(camera.string() + ": there is neither data.csv nor an image in data/");
    return images;
  }
  const auto text = read_text(csv);
  if (!text) return tl::unexpected(text.error());
  std::string problem;
  Timestamp last = std::numeric_limits<Timestamp>::min();
  for_each_line(*text, [&](std::string_view line, int number) {
    const auto parts = split(line);
    const auto stamp = parts.size() >= 2 ? parse_stamp(parts[0]) : std::nullopt;
    const std::string where = csv.string() + ":" + std::to_string(number);
    if (!stamp) {
      problem = where + ": it must hold a stamp in nanoseconds and a file name";
    } else if (*stamp <= last) {
      problem =
          where + ": the stamp " + std::string(parts[0]) + " is not later than the one before it; stamps must rise";
    } else {
      last = *stamp;
      images[*stamp] = camera / "data" / parts[1];
    }
    return problem.empty();
  });
  if (!problem.empty()) return fail(problem);
  if (images.empty()) return fail(csv.string() + ": no image is listed in it");
  return images;
}

}  // namespace

Result<Recording> read_euroc(const Request& request) {
  const fs::path base = fs::is_directory(request.folder / "mav0") ? request.folder / "mav0" : request.folder;
  Recording recording;
  recording.kind = SequenceKind::euroc;
  recording.name = "EuRoC sequence";
  const bool has_right = fs::is_directory(base / "cam1");
  recording.sensor = request.wanted.value_or(has_right ? Sensor::stereo : Sensor::monocular);
  if (recording.sensor == Sensor::rgbd)
    return fail(request.folder.string() + ": a EuRoC sequence has no depth images; --sensor must be stereo or mono");
  if (recording.sensor == Sensor::stereo && !has_right)
    return fail((base / "cam1").string() + ": the right camera is missing; without it use --sensor mono");
  const auto left = read_sensor(base / "cam0" / "sensor.yaml");
  if (!left) return tl::unexpected(left.error());
  const auto images = read_list(base / "cam0");
  if (!images) return tl::unexpected(images.error());
  recording.camera = request.given ? request.given->camera : left->camera;
  SE3 T_bc = left->T_bs;
  if (recording.sensor == Sensor::stereo) {
    const auto right = read_sensor(base / "cam1" / "sensor.yaml");
    if (!right) return tl::unexpected(right.error());
    auto rectification = StereoRectification::create(left->camera, right->camera, right->T_bs.inverse() * left->T_bs);
    if (!rectification) return fail(request.folder.string() + ": " + rectification.error().message);
    recording.rectification = std::move(*rectification);
    recording.camera = recording.rectification->camera();
    T_bc = T_bc * recording.rectification->T_left_rectified();
    const auto rights = read_list(base / "cam1");
    if (!rights) return tl::unexpected(rights.error());
    for (const auto& [stamp, image] : *images) {
      const auto pair = rights->find(stamp);
      if (pair != rights->end()) recording.frames.push_back({stamp, image, pair->second, {}});
    }
    if (recording.frames.empty())
      return fail(request.folder.string() + ": no left image has a right one of the same stamp");
  } else {
    for (const auto& [stamp, image] : *images) recording.frames.push_back({stamp, image, {}, {}});
  }
  const fs::path truth = base / "state_groundtruth_estimate0" / "data.csv";
  if (fs::exists(truth)) recording.truth = Truth{truth, {}, T_bc};
  return recording;
}

}  // namespace covis::io
