// SPDX-License-Identifier: Apache-2.0
// Shared by the readers of COLMAP's text and binary models: the bounds of cameras and poses. Errors do not name the
// place.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "covis/exchange/colmap_model.h"

namespace covis::exchange {

inline constexpr const char* kOneCameraWanted =
    "one is wanted: images of one size and lens as COLMAP's feature_extractor takes them with "
    "--ImageReader.single_camera 1, or the model of one camera's images alone";

// The number of figures of a camera model, behind the image size; nullopt: no lens of Covis is of that model.
std::optional<size_t> colmap_figures(const std::string& model);
Error unknown_colmap_model(const std::string& model);
// `figures`: as many as the model has.
Result<Camera> colmap_camera(const std::string& model, int64_t width, int64_t height, std::span<const double> figures);

// Fills in the pose; q: w, x, y, z. Errors: the quaternion or the translation, or a name outside the folder of images.
Result<ColmapModel::Image> colmap_image(const std::string& name, const Eigen::Vector4d& q, const Eigen::Vector3d& t);

// cameras.bin and images.bin of a folder.
Result<ColmapModel> read_colmap_binary(const std::filesystem::path& folder);
Result<Camera> read_colmap_binary_camera(const std::filesystem::path& file, uint32_t& id);

// `file`: that of the images. They are put in the order of their ids.
Result<ColmapModel> colmap_model(const Camera& camera, std::map<int64_t, ColmapModel::Image> by_id,
                                 const std::filesystem::path& file);

}  // namespace covis::exchange
