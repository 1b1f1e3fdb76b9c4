// SPDX-License-Identifier: Apache-2.0
// The text files of each kind of recording, beside small images that are good. An input has the files of its kind, with
// a line of "%%" before each but the first.
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "covis/io/npy.h"
#include "covis/io/sequence.h"
#include "scratch.h"
#include "target.h"

namespace covis::fuzz {
namespace {

namespace fs = std::filesystem;

void image(const fs::path& file, int type) {
  fs::create_directories(file.parent_path());
  cv::imwrite(file.string(), cv::Mat(48, 64, type, cv::Scalar::all(100)));
}

void open(const fs::path& folder, const std::vector<std::string>& names, std::string_view bytes) {
  constexpr std::string_view kBetween = "\n%%\n";
  for (const std::string& name : names) {
    const size_t at = std::min(bytes.find(kBetween), bytes.size());
    fs::create_directories((folder / name).parent_path());
    write_file(folder / name, bytes.substr(0, at));
    bytes.remove_prefix(std::min(bytes.size(), at + kBetween.size()));
  }
  for (const std::optional<Sensor> sensor : {std::optional<Sensor>(), std::optional(Sensor::monocular)}) {
    io::SequenceOptions options;
    options.sensor = sensor;
    options.decode_ahead = 1;
    const auto opened = io::open_sequence(folder.string(), options);
    if (!opened) continue;
    io::Sequence& sequence = **opened;
    require(sequence.camera().width > 0 && sequence.camera().height > 0, "a recording has an image size");
    static_cast<void>(sequence.frame_rate());
    static_cast<void>(sequence.description());
    if (sequence.truth()) static_cast<void>(io::load_truth(sequence));
    for (int i = 0; i < 3; ++i) {
      const auto next = sequence.next();
      if (next && !*next) break;
    }
  }
}

void run_tum(std::string_view bytes) {
  static const fs::path folder = [] {
    const fs::path made = scratch_folder() / "tum";
    for (const char* name : {"0.png", "1.png"}) {
      image(made / "rgb" / name, CV_8UC3);
      image(made / "depth" / name, CV_16UC1);
    }
    return made;
  }();
  open(folder, {"rgb.txt", "depth.txt", "camera.yaml", "groundtruth.txt"}, bytes);
}

void run_kitti(std::string_view bytes) {
  static const fs::path folder = [] {
    const fs::path made = scratch_folder() / "kitti";
    for (const char* name : {"000000.png", "000001.png"}) {
      image(made / "image_0" / name, CV_8UC1);
      image(made / "image_1" / name, CV_8UC1);
    }
    return made;
  }();
  open(folder, {"calib.txt", "times.txt", "poses.txt"}, bytes);
}

void run_euroc(std::string_view bytes) {
  static const fs::path folder = [] {
    const fs::path made = scratch_folder() / "euroc";
    for (const char* camera : {"cam0", "cam1"}) {
      for (const char* name : {"1000000000.png", "1050000000.png"})
        image(made / "mav0" / camera / "data" / name, CV_8UC1);
    }
    return made;
  }();
  open(folder,
       {"mav0/cam0/data.csv", "mav0/cam1/data.csv", "mav0/cam0/sensor.yaml", "mav0/cam1/sensor.yaml",
        "mav0/state_groundtruth_estimate0/data.csv"},
       bytes);
}

void run_images(std::string_view bytes) {
  static const fs::path folder = [] {
    const fs::path made = scratch_folder() / "images";
    for (const char* name : {"0.png", "1.png"}) image(made / name, CV_8UC1);
    return made;
  }();
  open(folder, {"camera.yaml", "times.txt"}, bytes);
}

void run_openloris(std::string_view bytes) {
  static const fs::path folder = [] {
    const fs::path made = scratch_folder() / "openloris";
    for (const char* name : {"0.png", "1.png"}) {
      image(made / "color" / name, CV_8UC3);
      image(made / "aligned_depth" / name, CV_16UC1);
    }
    return made;
  }();
  open(folder, {"color.txt", "aligned_depth.txt", "sensors.yaml", "trans_matrix.yaml", "groundtruth.txt"}, bytes);
}

void run_pairs(std::string_view bytes) {
  static const fs::path folder = [] {
    const fs::path made = scratch_folder() / "pairs";
    for (const char* name : {"0", "1"}) {
      image(made / (std::string("frame-") + name + ".color.png"), CV_8UC3);
      image(made / (std::string("frame-") + name + ".depth.png"), CV_16UC1);
    }
    return made;
  }();
  open(folder, {"camera.yaml", "frame-0.pose.txt", "frame-1.pose.txt"}, bytes);
}

void run_npy(std::string_view bytes) {
  const std::vector<char> copy(bytes.begin(), bytes.end());  // so that the sanitizer sees a read past its end
  ImageF depth;
  if (!io::parse_npy("depth.npy", {copy.data(), copy.size()}, depth)) return;
  require(static_cast<size_t>(depth.width()) * static_cast<size_t>(depth.height()) * sizeof(float) <= bytes.size(),
          "an array is as large as its file at most");
}

const std::string kCamera = "width: 64\nheight: 48\nfx: 50\nfy: 50\ncx: 32\ncy: 24\n";

std::vector<std::string> tum_seeds() {
  return {"# colour\n1000.0 rgb/0.png\n1000.1 rgb/1.png\n%%\n1000.01 depth/0.png\n1000.11 depth/1.png\n%%\n" + kCamera +
          "%%\n# truth\n1000.0 0 0 0 0 0 0 1\n"};
}

std::vector<std::string> kitti_seeds() {
  return {
      "P0: 50 0 32 0 0 50 24 0 0 0 1 0\nP1: 50 0 32 -25 0 50 24 0 0 0 1 0\n%%\n0\n0.1\n%%\n1 0 0 0 0 1 0 0 0 0 1 0\n1 "
      "0 0 "
      "0 0 1 0 0 0 0 1 1\n"};
}

std::vector<std::string> euroc_seeds() {
  const std::string list = "#timestamp,filename\n1000000000,1000000000.png\n1050000000,1050000000.png\n%%\n";
  const auto sensor = [](const std::string& x) {
    return "T_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, " + x +
           ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nrate_hz: 20\nresolution: [64, 48]\ncamera_model: pinhole\n"
           "intrinsics: [50, 50, 32, 24]\ndistortion_model: radial-tangential\n"
           "distortion_coefficients: [0.01, 0, 0, 0]\n%%\n";
  };
  return {list + list + sensor("0") + sensor("0.1") + "#timestamp\n1000000000,0,0,0,1,0,0,0\n"};
}

std::vector<std::string> openloris_seeds() {
  const std::string color = "0.0 color/0.png\n0.1 color/1.png\n%%\n";
  const std::string depth = "0.01 aligned_depth/0.png\n0.1 aligned_depth/1.png\n%%\n";
  const std::string sensors =
      "%YAML:1.0\n---\nd400_color_optical_frame:\n   width: 64\n   height: 48\n   intrinsics: !!opencv-matrix\n"
      "      rows: 1\n      cols: 4\n      dt: d\n      data: [50, 32, 51, 24]\n%%\n";
  const std::string places =
      "%YAML:1.0\n---\ntrans_matrix:\n - parent_frame: base_link\n   child_frame: d400_color_optical_frame\n"
      "   matrix: !!opencv-matrix\n      rows: 4\n      cols: 4\n      dt: d\n"
      "      data: [0, 0, 1, 0.25, -1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 1]\n%%\n";
  const std::string truth = "#Time px py pz qx qy qz qw\n0 1 2 3 0 0 0 1\n";
  return {color + depth + sensors + places + truth,
          color + depth + "d400_color: {width: 64, height: 48, intrinsics: [50, 32, 51, 24]}\n%%\n%%\n" + truth};
}

std::vector<std::string> npy_seeds() {
  const auto array = [](std::string header, char version) {
    header += '\n';
    std::string size = {static_cast<char>(header.size()), '\0'};
    if (version == 2) size += std::string(2, '\0');
    return "\x93NUMPY" + std::string{version, '\0'} + size + header + std::string(6 * sizeof(float), '\x40');
  };
  return {array("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }", 1),
          array("{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2), }", 2)};
}

std::vector<std::string> pairs_seeds() {
  return {kCamera + "%%\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n%%\n-inf nan 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"};
}

std::vector<std::string> images_seeds() { return {kCamera + "%%\n0\n0.1\n"}; }

}  // namespace

std::vector<Target> recording_targets() {
  return {{"tum", run_tum, tum_seeds},
          {"kitti", run_kitti, kitti_seeds},
          {"euroc", run_euroc, euroc_seeds},
          {"images", run_images, images_seeds},
          {"openloris", run_openloris, openloris_seeds},
          {"pairs", run_pairs, pairs_seeds},
          {"npy", run_npy, npy_seeds}};
}

}  // namespace covis::fuzz
