// SPDX-License-Identifier: Apache-2.0
// A model of COLMAP as it is read, in its text or its binary format.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"

namespace covis::exchange {

struct ColmapModel {
  struct Image {
    std::string name;  // as COLMAP has it, a path below its folder of images
    SE3 T_cw;
    std::vector<int64_t> points;  // ids of the points that it shows, rising
  };
  Camera camera;
  std::vector<Image> images;  // by rising id
};

// Reads cameras.txt and images.txt, or without the first cameras.bin and images.bin. Errors name the file, and line or
// image: several cameras (a map has one), a camera model that no lens of Covis is (known are SIMPLE_PINHOLE, PINHOLE,
// SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE), an image of another camera, numbers that are none, counts that the
// file is too short for.
Result<ColmapModel> read_colmap(const std::filesystem::path& folder);

// Reads cameras.txt or cameras.bin alone.
Result<Camera> read_colmap_camera(const std::filesystem::path& file);

}  // namespace covis::exchange
