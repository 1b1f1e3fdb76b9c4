// SPDX-License-Identifier: Apache-2.0
// Trajectories: lists of stamped poses T_wc (camera to world), read and written as TUM, KITTI and EuRoC files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/time.h"
#include "covis/geometry/se3.h"

namespace covis {

struct StampedPose {
  Timestamp stamp = 0;
  SE3 T_wc;
};
using Trajectory = std::vector<StampedPose>;

namespace io {

enum class TrajectoryFormat { automatic, tum, kitti, euroc };

// automatic: recognised from the number of columns and the separator. Stamps are in seconds; they are in nanoseconds
// when they have 16 digits or more before the point, and in EuRoC rows when they are integers. KITTI rows have no
// stamps: these come from `stamps` (a times.txt) or, without it, are the row number in seconds. Blank lines and lines
// starting with '#' are skipped; any other malformed line is an error with file and line.
Result<Trajectory> read_trajectory(const std::filesystem::path& file,
                                   TrajectoryFormat format = TrajectoryFormat::automatic,
                                   const std::filesystem::path& stamps = {});
// Writes to a temporary name and renames, so that a full disk leaves no partial file.
Result<void> write_trajectory(const std::filesystem::path& file, const Trajectory& trajectory, TrajectoryFormat format);
// Maps that are not joined have a world each, and so a file each: FILE, FILE_map1, … Files of that name with higher
// numbers from an earlier run are removed, because they would be mistaken for this run's. The first failure is
// returned; the other files are written all the same.
Result<void> write_trajectories(const std::filesystem::path& file, const std::vector<Trajectory>& of_map,
                                TrajectoryFormat format);

}  // namespace io
}  // namespace covis
