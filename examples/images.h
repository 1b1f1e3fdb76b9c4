// SPDX-License-Identifier: Apache-2.0
// For the examples: the images of a folder, and their camera from the command line.
#pragma once

#include <covis/covis.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

inline std::vector<std::string> images_of(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string suffix = entry.path().extension().string();
    if (suffix == ".png" || suffix == ".jpg") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The image stays the matrix's.
inline covis::GreyImage view(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, static_cast<ptrdiff_t>(image.step)};
}

inline cv::Mat read_grey(const std::string& file) {
  cv::Mat image = cv::imread(file, cv::IMREAD_GRAYSCALE);
  if (image.empty()) std::fprintf(stderr, "%s: it can't be read\n", file.c_str()), std::exit(1);
  return image;
}

// A pinhole camera of this focal length, pixels, whose principal point is the middle of the image.
inline covis::CameraParameters camera_of(const cv::Mat& image, double focal) {
  return {.width = image.cols,
          .height = image.rows,
          .fx = focal,
          .fy = focal,
          .cx = image.cols / 2.0,
          .cy = image.rows / 2.0};
}

inline int fail(const std::string& error) { return std::fprintf(stderr, "%s\n", error.c_str()), 1; }
