// SPDX-License-Identifier: Apache-2.0
#include "covis/io/trajectory.h"

#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <system_error>

#include "covis/core/atomic_file.h"
#include "covis/io/files.h"
#include "covis/io/output_check.h"

namespace covis::io {
namespace {

// Parses the numbers of a row from `first` on; nullopt when one is not a finite number.
std::optional<std::vector<double>> numbers(const std::vector<std::string_view>& parts, size_t first) {
  std::vector<double> values;
  for (size_t i = first; i < parts.size(); ++i) {
    const auto value = parse_double(parts[i]);
    if (!value) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

// q is given as x y z w.
std::optional<SE3> from_quaternion(double tx, double ty, double tz, double x, double y, double z, double w) {
  const Eigen::Quaterniond q(w, x, y, z);
  if (std::abs(q.norm() - 1) > 1e-2) return std::nullopt;
  return SE3(q, Eigen::Vector3d(tx, ty, tz));
}

// Rotation from the usual axes of a camera (right, down, forward) to forward, right, down.
SE3 forward_right_down() {
  Eigen::Matrix3d R;
  R << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return {R, Eigen::Vector3d::Zero()};
}

// EuRoC's stamps are whole nanoseconds; TUM's columns may have commas between them, too.
bool is_euroc(std::string_view line) {
  const size_t comma = line.find(',');
  return comma != line.npos && line.find_first_not_of("-0123456789") == comma;
}

TrajectoryFormat format_of(const std::filesystem::path& file, std::string_view line, size_t columns) {
  if (columns == 12) return TrajectoryFormat::kitti;
  if (is_euroc(line)) return TrajectoryFormat::euroc;
  if (columns == 7) return TrajectoryFormat::tartanair;
  return file.string().ends_with(".gt.freiburg") ? TrajectoryFormat::icl_nuim : TrajectoryFormat::tum;
}

// v: the numbers of a row behind its stamp, as many as its format has.
std::optional<SE3> pose_of(TrajectoryFormat format, const std::vector<double>& v) {
  switch (format) {
    case TrajectoryFormat::kitti:
      return pose_of_matrix(v);
    case TrajectoryFormat::euroc:
      return from_quaternion(v[0], v[1], v[2], v[4], v[5], v[6], v[3]);
    case TrajectoryFormat::tartanair: {
      const auto pose = from_quaternion(v[0], v[1], v[2], v[3], v[4], v[5], v[6]);
      return pose ? std::optional(*pose * forward_right_down()) : std::nullopt;
    }
    case TrajectoryFormat::icl_nuim:
      // With F = diag(1, -1, 1) the turn R becomes F R F, which is minus its angle about the axis that F mirrors.
      return from_quaternion(v[0], -v[1], v[2], -v[3], v[4], -v[5], v[6]);
    default:
      return from_quaternion(v[0], v[1], v[2], v[3], v[4], v[5], v[6]);
  }
}

// text: the stamp in a row.
std::optional<Timestamp> stamp_of(TrajectoryFormat format, std::string_view text) {
  auto stamp = parse_stamp(text, format == TrajectoryFormat::euroc ? WholeStamp::nanoseconds : WholeStamp::seconds);
  if (stamp && format == TrajectoryFormat::icl_nuim) *stamp /= kIclNuimRate;
  return stamp;
}

void append(std::string& text, const char* format, double value) {
  char buffer[400];  // the greatest double has 309 digits before the point
  text.append(buffer, static_cast<size_t>(std::snprintf(buffer, sizeof buffer, format, value)));
}

// FILE_map1 and so on.
bool is_of_map(const std::filesystem::path& one, const std::filesystem::path& file) {
  const std::string stem = file.stem().string() + "_map", name = one.stem().string();
  return one.extension() == file.extension() && name.size() > stem.size() && name.starts_with(stem) &&
         name.find_first_not_of("0123456789", stem.size()) == name.npos;
}

// Returns true where such a file was there and is gone now.
bool remove_ours(const std::filesystem::path& file, OutputKind kind) {
  std::error_code error;
  return std::filesystem::is_regular_file(file, error) && may_replace(file, kind).value_or(false) &&
         std::filesystem::remove(file, error);
}

}  // namespace

std::optional<SE3> pose_of_matrix(const std::vector<double>& v) {
  Eigen::Matrix3d R;
  R << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-2 || R.determinant() < 0) return std::nullopt;
  return SE3(R, Eigen::Vector3d(v[3], v[7], v[11])).normalized();
}

bool has_stamps(TrajectoryFormat format) {
  return format != TrajectoryFormat::kitti && format != TrajectoryFormat::tartanair;
}

Result<TrajectoryFormat> trajectory_format(const std::filesystem::path& file, TrajectoryFormat format) {
  if (format != TrajectoryFormat::automatic) return format;
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  for_each_line(*text, [&](std::string_view line, int) {
    format = format_of(file, line, split(line).size());
    return false;
  });
  return format;
}

Result<Trajectory> read_trajectory(const std::filesystem::path& file, TrajectoryFormat format,
                                   const std::filesystem::path& stamps_file) {
  const auto text = read_text(file);
  if (!text) return tl::unexpected(text.error());
  std::vector<Timestamp> stamps;
  if (!stamps_file.empty()) {
    auto read = read_stamps(stamps_file);
    if (!read) return tl::unexpected(read.error());
    stamps = std::move(*read);
  }
  Trajectory trajectory;
  std::string problem;
  TrajectoryFormat row = format;  // the first row tells the format of all
  for_each_line(*text, [&](std::string_view line, int number) {
    const std::vector<std::string_view> parts = split(line);
    if (row == TrajectoryFormat::automatic) row = format_of(file, line, parts.size());
    const size_t least = row == TrajectoryFormat::kitti ? 12 : row == TrajectoryFormat::tartanair ? 7 : 8;
    const bool sized = row == TrajectoryFormat::euroc ? parts.size() >= least : parts.size() == least;
    if (!sized) {
      problem = place(file, number) + ": it has " + std::to_string(parts.size()) +
                " columns; TUM has 8 (t tx ty tz qx qy qz qw), KITTI 12, EuRoC at least 8 (ns, x, y, z, qw, qx, qy, "
                "qz), TartanAir 7 (tx ty tz qx qy qz qw)";
      return false;
    }
    const auto v = numbers(parts, has_stamps(row) ? 1 : 0);
    std::optional<Timestamp> stamp;
    if (has_stamps(row)) {
      stamp = stamp_of(row, parts[0]);
    } else {
      const size_t index = trajectory.size();
      const Timestamp step = row == TrajectoryFormat::kitti ? 1'000'000'000 : kTartanAirStep;
      stamp = index < stamps.size() ? stamps[index] : static_cast<Timestamp>(index) * step;
    }
    const std::optional<SE3> pose = v ? pose_of(row, *v) : std::nullopt;
    if (!v) {
      problem = place(file, number) + ": a column is not a finite number";
    } else if (!stamp) {
      problem = place(file, number) + ": its stamp is no number of seconds (or of nanoseconds) within 146 years of 0";
    } else if (!pose) {
      problem =
          place(file, number) + ": the rotation is not valid (a unit quaternion or an orthonormal matrix is expected)";
    } else if (!(pose->t().cwiseAbs().maxCoeff() <= kFarthestPosition)) {
      problem = place(file, number) + ": the position is farther than 1e12 m from the origin";
    } else {
      trajectory.push_back({*stamp, *pose});
    }
    return problem.empty();
  });
  if (!problem.empty()) return fail(problem);
  if (trajectory.empty()) return fail(file.string() + ": there is no pose in it");
  if (!stamps_file.empty() && !has_stamps(row) && stamps.size() != trajectory.size())
    return fail(file.string() + ": it has " + std::to_string(trajectory.size()) + " rows, and " + stamps_file.string() +
                " has " + std::to_string(stamps.size()) +
                " stamps; a file with one stamp for each of these rows is wanted");
  return trajectory;
}

Result<void> write_trajectory(const std::filesystem::path& file, const Trajectory& trajectory,
                              TrajectoryFormat format) {
  std::string text;
  if (format == TrajectoryFormat::euroc) text = "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z []\n";
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d& t = pose.T_wc.t();
    if (format == TrajectoryFormat::kitti) {
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 4; ++c) {
          if (r + c > 0) text += ' ';
          append(text, "%.9e", c < 3 ? pose.T_wc.R()(r, c) : t(r));
        }
      }
    } else {
      const Eigen::Quaterniond q = pose.T_wc.q();
      const bool euroc = format == TrajectoryFormat::euroc;
      const char* number = euroc ? ",%.9f" : " %.9f";
      text += euroc ? std::to_string(pose.stamp) : stamp_text(pose.stamp);
      for (int k = 0; k < 3; ++k) append(text, number, t(k));
      if (euroc) append(text, number, q.w());
      for (const double value : {q.x(), q.y(), q.z()}) append(text, number, value);
      if (!euroc) append(text, number, q.w());
    }
    text += '\n';
  }
  return write_atomically(file, text);
}

std::filesystem::path times_file(const std::filesystem::path& file) {
  return file.parent_path() / (file.stem().string() + "_times" + file.extension().string());
}

Result<void> write_with_times(const std::filesystem::path& file, const Trajectory& trajectory,
                              TrajectoryFormat format) {
  const std::filesystem::path times = times_file(file);
  if (has_stamps(format)) {
    remove_ours(times, OutputKind::times);
    return write_trajectory(file, trajectory, format);
  }
  if (auto fits = check_output(times, OutputKind::times); !fits) return fits;
  std::string text = "# seconds of each row of " + file.filename().string() + "\n";
  for (const StampedPose& pose : trajectory) text += stamp_text(pose.stamp) + "\n";
  auto written = write_trajectory(file, trajectory, format);
  return written ? write_atomically(times, text) : written;
}

Result<void> write_trajectories(const std::filesystem::path& file, const std::vector<Trajectory>& of_map,
                                TrajectoryFormat format) {
  Result<void> problem;
  for (size_t m = 0;; ++m) {
    const std::string name = file.stem().string() + (m > 0 ? "_map" + std::to_string(m) : "");
    const std::filesystem::path one = file.parent_path() / (name + file.extension().string());
    if (m < of_map.size()) {
      auto written = check_output(one, OutputKind::trajectory);
      if (written) written = write_with_times(one, of_map[m], format);
      if (!written && problem) problem = written;
      continue;
    }
    if (!remove_ours(one, OutputKind::trajectory)) return problem;
    remove_ours(times_file(one), OutputKind::times);
  }
}

Result<void> check_trajectories(const std::filesystem::path& file, const std::vector<std::filesystem::path>& inputs,
                                TrajectoryFormat format) {
  const auto check = [&](const std::filesystem::path& one) {
    auto fits = check_output(one, OutputKind::trajectory, inputs);
    return fits && !has_stamps(format) ? check_output(times_file(one), OutputKind::times, inputs) : fits;
  };
  if (auto fits = check(file); !fits) return fits;
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::filesystem::path one = file.parent_path() / entry->path().filename();
    if (!is_of_map(one, file)) continue;
    if (auto fits = check(one); !fits) return fits;
  }
  return {};
}

}  // namespace covis::io
