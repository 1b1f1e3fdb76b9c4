// SPDX-License-Identifier: Apache-2.0
// EuRoC sequences (Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 2016): mav0/cam0, cam1 with data.csv
// and sensor.yaml.
#include <map>
#include <optional>

#include "covis/io/bad_frames.h"
#include "covis/io/files.h"
#include "covis/io/recording.h"
#include "covis/io/sensor_file.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;

using Images = std::map<Timestamp, fs::path>;

// Reads rows of "stamp in nanoseconds, file name". Notes what is left out.
Result<Images> read_csv(const fs::path& csv, BadFrames bad_frames, Recording& recording) {
  const auto text = read_text(csv);
  if (!text) return tl::unexpected(text.error());
  std::vector<Timestamp> stamps;
  std::vector<fs::path> files;
  std::vector<std::string> places;
  std::string problem;
  for_each_line(*text, [&](std::string_view line, int number) {
    const auto parts = split(line);
    const auto stamp = parse_stamp(parts.empty() ? line : parts[0], WholeStamp::nanoseconds);
    const std::string where = place(csv, number);
    if (!stamp || parts.size() < 2) {
      problem = where + ": it must hold a stamp in nanoseconds and a file name";
      return false;
    }
    stamps.push_back(*stamp);
    places.push_back(where);
    files.push_back(csv.parent_path() / "data" / parts[1]);
    return true;
  });
  if (!problem.empty()) return fail(problem);
  if (stamps.empty()) return fail(csv.string() + ": no image is listed in it");
  const auto rising = pass_over_fallen(
      stamps, "rows", [&](size_t i) { return places[i]; }, bad_frames, recording);
  if (!rising) return tl::unexpected(rising.error());
  Images images;
  for (const size_t i : *rising) images[stamps[i]] = files[i];
  return images;
}

// Maps stamps to images, from data.csv or, if there is none, from the file names.
Result<Images> read_list(const fs::path& camera, BadFrames bad_frames, Recording& recording) {
  const fs::path csv = camera / "data.csv";
  if (fs::exists(csv)) return read_csv(csv, bad_frames, recording);
  Images images;
  for (const fs::path& image : list_images(camera / "data")) {
    if (const auto stamp = parse_stamp(image.stem().string(), WholeStamp::nanoseconds)) images[*stamp] = image;
  }
  if (images.empty()) {
    return fail(camera.string() +
                ": there is neither data.csv nor an image in data/ with its stamp in nanoseconds as its name");
  }
  return images;
}

// Pairs images with equal stamps, or lists the left images alone. A list may name images that a copy leaves out: such
// frames are skipped. Where a right image is listed and missing, though the left one is there, the frame is bad.
Result<void> list_frames(const fs::path& base, BadFrames bad_frames, Recording& recording) {
  const bool stereo = recording.sensor == Sensor::stereo;
  const auto left = read_list(base / "cam0", bad_frames, recording);
  if (!left) return tl::unexpected(left.error());
  Images right;
  if (stereo) {
    auto read = read_list(base / "cam1", bad_frames, recording);
    if (!read) return tl::unexpected(read.error());
    right = std::move(*read);
  }
  size_t missing = 0, single = 0;
  for (const auto& [stamp, image] : *left) {
    const auto pair = right.find(stamp);
    if (!is_there(image)) {
      ++missing;
    } else if (stereo && pair == right.end()) {
      ++single;
    } else {
      recording.frames.push_back({stamp, image, stereo ? pair->second : fs::path(), {}});
    }
  }
  const std::string cam0 = (base / "cam0").string();
  if (recording.frames.empty() && missing < left->size())
    return fail(base.string() + ": no left image has a right one of the same stamp");
  if (recording.frames.empty()) return fail(cam0 + ": none of the images in data.csv is there");
  if (missing > 0)
    recording.notes.push_back(std::to_string(missing) + " of " + std::to_string(left->size()) + " images of " + cam0 +
                              " are listed but missing, and left out");
  if (single > 0)
    note_left_out(single, left->size(), "images of " + cam0 + " have no right image of the same stamp", recording);
  return {};
}

// The camera's pose in the body frame, or why nobody says it.
struct OnBody {
  std::optional<SE3> T_bc;
  std::string problem = {};
};

// Of a sensor.yaml beside a camera file that is given, the pose alone counts.
OnBody pose_beside_given_camera(const fs::path& sensor_file) {
  if (!fs::exists(sensor_file)) return {std::nullopt, sensor_file.string() + ": it is not there"};
  const auto pose = read_sensor_pose(sensor_file);
  return pose ? OnBody{*pose} : OnBody{std::nullopt, pose.error().message};
}

// A file that is there and can't be used is noted always, one that is not there where it is missed.
void note_unknown_pose(const OnBody& camera, const fs::path& sensor_file, Recording& recording) {
  if (camera.T_bc || (!recording.truth && !fs::exists(sensor_file))) return;
  std::string note = camera.problem + "; where the camera is on the body is not known";
  if (recording.truth)
    note += ", and errors will hold the arm between the two, as " + recording.truth->file.string() + " is of the body";
  recording.notes.push_back(std::move(note));
}

// Reads the camera (rectified, when stereo). A given camera file means that the images are rectified already.
Result<OnBody> find_camera(const Request& request, const fs::path& base, Recording& recording) {
  const fs::path left_file = base / "cam0" / "sensor.yaml", right_file = base / "cam1" / "sensor.yaml";
  if (request.given) {
    recording.camera = request.given->camera;
    recording.bits = request.given->bits;
    recording.calibration = request.given->file.string();
    return pose_beside_given_camera(left_file);
  }
  if (!fs::exists(left_file)) return tl::unexpected(no_calibration(request.folder, left_file.string()));
  const auto left = read_sensor_file(left_file);
  if (!left) return tl::unexpected(left.error());
  recording.camera = left->camera;
  recording.calibration = left_file.string();
  if (recording.sensor != Sensor::stereo) return OnBody{left->T_bs};
  const auto right = read_sensor_file(right_file);
  if (!right) return tl::unexpected(right.error());
  auto rectification = StereoRectification::create(left->camera, right->camera, right->T_bs.inverse() * left->T_bs);
  if (!rectification)
    return fail(left_file.string() + ", " + right_file.string() + ": " + rectification.error().message);
  recording.rectification = std::move(*rectification);
  recording.camera = recording.rectification->camera();
  return OnBody{left->T_bs * recording.rectification->T_left_rectified()};
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
  const auto on_body = find_camera(request, base, recording);
  if (!on_body) return tl::unexpected(on_body.error());
  if (auto listed = list_frames(base, request.bad_frames, recording); !listed) return tl::unexpected(listed.error());
  // TUM VI names its ground truth, which is also that of the body, mocap0.
  for (const char* source : {"state_groundtruth_estimate0", "mocap0"}) {
    const fs::path truth = base / source / "data.csv";
    if (!recording.truth && fs::exists(truth)) recording.truth = Truth{truth, on_body->T_bc};
  }
  note_unknown_pose(*on_body, base / "cam0" / "sensor.yaml", recording);
  return recording;
}

}  // namespace covis::io
