// SPDX-License-Identifier: Apache-2.0
// Trajectories: lists of stamped poses T_wc (camera to world), read and written as TUM, KITTI and EuRoC files, and read
// as TartanAir and ICL-NUIM have them.
#pragma once

#include <filesystem>
#include <optional>
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

// tartanair: seven numbers a row, tx ty tz qx qy qz qw, of a camera whose axes are forward, right and down; T_wc is
// that of the usual axes, in the file's world. icl_nuim: a TUM file that numbers frames where the stamps would be
// and whose y axes point up, in the world and in the camera; its poses are returned with both pointing down.
enum class TrajectoryFormat { automatic, tum, kitti, euroc, tartanair, icl_nuim };

// Time between the frames of data sets that give no stamps. TartanAir: 10 Hz, the rate of its second version; ICL-NUIM:
// its number of frames a second, by which the number of a frame is divided.
inline constexpr Timestamp kTartanAirStep = 100'000'000;  // ns
inline constexpr Timestamp kIclNuimRate = 30;             // Hz

// Positions are at most so far from the origin, in metres, as in maps: squares of greater numbers are soon infinite.
inline constexpr double kFarthestPosition = 1e12;

// Returns the pose of a matrix given row by row, of 12 finite numbers or more; nullopt where it has no rotation.
std::optional<SE3> pose_of_matrix(const std::vector<double>& values);

// automatic: recognised from the number of columns, the separator and the stamp (EuRoC's are whole nanoseconds, with
// commas behind them), and by the name's ending .gt.freiburg (ICL-NUIM).
// Stamps are in seconds, or in the unit that parse_stamp() knows by their number of digits; in EuRoC rows they are in
// nanoseconds when they are integers. KITTI and TartanAir rows have no stamps: these come from `stamps` (a times.txt)
// or, without it, from the row's number, in seconds or by kTartanAirStep. It is an error when there are more or fewer
// stamps than rows. Blank lines and lines starting with '#' are skipped; any other malformed line is an error with file
// and line.
Result<Trajectory> read_trajectory(const std::filesystem::path& file,
                                   TrajectoryFormat format = TrajectoryFormat::automatic,
                                   const std::filesystem::path& stamps = {});
// The format of a file as its first row tells it, where `format` is automatic.
Result<TrajectoryFormat> trajectory_format(const std::filesystem::path& file, TrajectoryFormat format);
// False: rows of this format have no stamps.
bool has_stamps(TrajectoryFormat format);
// Writes to a temporary name and renames, so that a full disk leaves no partial file. format: tum, kitti or euroc.
Result<void> write_trajectory(const std::filesystem::path& file, const Trajectory& trajectory, TrajectoryFormat format);
// The file with the stamps of a trajectory whose rows have none: trajectory_times.txt beside trajectory.txt.
std::filesystem::path times_file(const std::filesystem::path& file);
// Writes a trajectory, and times_file() where the format has no stamps; where it has, one of an earlier run goes.
Result<void> write_with_times(const std::filesystem::path& file, const Trajectory& trajectory, TrajectoryFormat format);
// Maps that are not joined have a world each, and so a file each: FILE, FILE_map1, … Files of that name with higher
// numbers from an earlier run are removed, because they would be mistaken for this run's. What is there and is no
// trajectory that Covis wrote stays. The first failure is returned; the other files are written all the same. Each has
// its times_file() as write_with_times() says.
Result<void> write_trajectories(const std::filesystem::path& file, const std::vector<Trajectory>& of_map,
                                TrajectoryFormat format);

// Refuses a name whose trajectory, or one that maps which are not joined may need, would replace a file given or one
// that is no trajectory of Covis; so with their times_file() where the format needs it. Inputs may be empty names.
Result<void> check_trajectories(const std::filesystem::path& file, const std::vector<std::filesystem::path>& inputs,
                                TrajectoryFormat format = TrajectoryFormat::tum);

}  // namespace io
}  // namespace covis
