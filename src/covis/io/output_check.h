// SPDX-License-Identifier: Apache-2.0
// Outputs replace neither a file that they are made from nor one of another kind. Commands ask before they begin. (Maps
// have storage::check_save_target, which asks the same for a map.) First bytes tell a kind, not always who wrote the
// file: the trajectory.png of a run may replace any PNG file, stats.jsonl and summary.json any JSON.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "covis/core/error.h"

namespace covis::io {

// Kinds of files that commands write, recognised by their first bytes. Some count only as Covis writes them: a picture
// of marked_picture(), a trajectory with our decimals, a camera, a page, a model with our first line. Of the others
// (png, point_cloud, vocabulary as text, bundler, json) a file of another program counts, too.
enum class OutputKind {
  picture,
  png,  // any, as earlier versions wrote no mark into that of a run
  page,
  point_cloud,
  trajectory,
  times,  // the stamps of a trajectory's rows
  camera,
  camera_estimate,  // the camera file of a recording that it was found from
  vocabulary,
  geojson,
  colmap,      // cameras.txt
  nerfstudio,  // transforms.json
  bundler,     // bundle.out
  scene,
  json
};

// The beginnings of a camera that a command was asked for, and of a camera_estimate.
inline constexpr std::string_view kCameraFile = "# covis ";
inline constexpr std::string_view kCameraEstimate = "# An estimate from the recording itself";

// True where nothing of another kind is lost: a file of that kind, an empty one, none. Also where it is no regular
// file, which writing refuses or writes into. Error: the file can't be read.
Result<bool> may_replace(const std::filesystem::path& file, OutputKind kind);

// Refuses an output that is one of the files that it is made from, under whichever name. Inputs may be empty names.
Result<void> check_other_file(const std::filesystem::path& out, const std::vector<std::filesystem::path>& inputs);

// The same, and refuses one that would replace a file of another kind.
Result<void> check_output(const std::filesystem::path& out, OutputKind kind,
                          const std::vector<std::filesystem::path>& inputs = {});

// The bytes of a PNG file with a note in it that Covis made it, so that a later picture may replace it.
std::string marked_picture(std::string png);
bool is_marked_picture(const std::filesystem::path& file);

}  // namespace covis::io
