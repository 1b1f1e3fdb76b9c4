// SPDX-License-Identifier: Apache-2.0
// For tests: small recordings of every layout, written into the test's own folder.
#pragma once

#include <gmock/gmock.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "covis/core/test_folder.h"
#include "covis/io/sequence.h"

namespace covis::io {

namespace fs = std::filesystem;

inline constexpr int kWidth = 64, kHeight = 48;

class RecordingTest : public testing::Test {
 protected:
  void write(const fs::path& name, const std::string& text) const {
    fs::create_directories((folder / name).parent_path());
    std::ofstream(folder / name, std::ios::binary) << text;
  }
  void image(const fs::path& name, int grey, int width = kWidth, int height = kHeight) const {
    fs::create_directories((folder / name).parent_path());
    cv::imwrite((folder / name).string(), cv::Mat(height, width, CV_8UC3, cv::Scalar::all(grey)));
  }
  void depth(const fs::path& name, int value, int width = kWidth, int height = kHeight) const {
    fs::create_directories((folder / name).parent_path());
    cv::imwrite((folder / name).string(), cv::Mat(height, width, CV_16U, cv::Scalar(value)));
  }
  void camera_yaml(const std::string& more = "") const {
    write("camera.yaml", "width: 64\nheight: 48\nfx: 50\nfy: 50\ncx: 32\ncy: 24\n" + more);
  }
  void tum(int frames = 3) const {
    std::string rgb = "# colour\n", depths;
    for (int i = 0; i < frames; ++i) {
      const std::string n = std::to_string(i);
      image("rgb/" + n + ".png", 10 + i);
      depth("depth/" + n + ".png", 5000 * (i + 1));
      rgb += "1000." + n + " rgb/" + n + ".png\n";
      depths += "1000." + n + "1 depth/" + n + ".png\n";
    }
    write("rgb.txt", rgb);
    write("depth.txt", depths);
    camera_yaml();
  }
  void kitti(int frames = 3) const {
    std::string times;
    for (int i = 0; i < frames; ++i) {
      char name[32];
      std::snprintf(name, sizeof name, "%06d.png", i);
      image(fs::path("image_0") / name, 20 + i);
      image(fs::path("image_1") / name, 30 + i);
      times += std::to_string(0.1 * i) + "\n";
    }
    write("calib.txt", "P0: 50 0 32 0 0 50 24 0 0 0 1 0\nP1: 50 0 32 -25 0 50 24 0 0 0 1 0\n");
    write("times.txt", times);
  }

  Result<std::unique_ptr<Sequence>> open(SequenceOptions options = {}) const {
    return open_sequence(folder.string(), options);
  }
  std::string open_error(SequenceOptions options = {}) const {
    const auto opened = open(options);
    EXPECT_FALSE(opened);
    return opened ? "" : opened.error().message;
  }

  // Two cameras 0.1 m apart along their x axis, which is the body's y axis: the camera is rotated by 90 degrees about
  // z.
  void euroc(const std::string& model = "radial-tangential") const {
    for (const int cam : {0, 1}) {
      const fs::path base = "mav0/cam" + std::to_string(cam);
      write(base / "sensor.yaml", "%YAML:1.0\nT_BS:\n  cols: 4\n  rows: 4\n  data: [0, -1, 0, 0.5, 1, 0, 0, " +
                                      std::to_string(0.1 * cam) +
                                      ", 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [64, 48]\nintrinsics: [50, 50, 32, 24]\n"
                                      "distortion_model: " +
                                      model + "\ndistortion_coefficients: [-0.1, 0.01, 0, 0]\n");
      write(base / "data.csv",
            "#timestamp [ns],filename\r\n1403715273262142976,1403715273262142976.png\r\n"
            "1403715273312143104,1403715273312143104.png\r\n");
      image(base / "data/1403715273262142976.png", 50 + cam);
      image(base / "data/1403715273312143104.png", 60 + cam);
    }
    write("mav0/state_groundtruth_estimate0/data.csv", "#t,x,y,z,w,x,y,z\n1403715273262142976,1,2,3,1,0,0,0,9,9,9\n");
  }

  const TemporaryFolder temporary_folder;
  const fs::path folder = temporary_folder.path();
};

class Sequences : public RecordingTest {};
class BadInput : public RecordingTest {};  // recordings with something wrong

}  // namespace covis::io
