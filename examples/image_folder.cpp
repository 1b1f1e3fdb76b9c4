// SPDX-License-Identifier: Apache-2.0
// A folder of images from one camera to a trajectory: each line is "stamp x y z qx qy qz qw" (TUM's format).
//   image_folder FOLDER FOCAL_LENGTH > trajectory.txt
#include "images.h"

int main(int argc, char** argv) {
  if (argc != 3) return fail("usage: image_folder FOLDER FOCAL_LENGTH");
  const std::vector<std::string> files = images_of(argv[1]);
  if (files.empty()) return fail(std::string(argv[1]) + ": no images in it");

  const auto slam = covis::Slam::create({
      .sensor = covis::SensorType::monocular,
      .camera = camera_of(read_grey(files[0]), std::atof(argv[2])),
      .timing = covis::Timing::deterministic,  // a recording: the same every time
  });
  if (!slam) return fail(slam.error());

  int64_t stamp = 0;
  for (const std::string& file : files) {
    const cv::Mat image = read_grey(file);
    const auto result = (*slam)->track({.stamp = stamp, .image = view(image)});
    if (!result) return fail(file + ": " + result.error());
    stamp += 33'333'333;  // 30 images a second
  }
  (*slam)->finish();

  const std::vector<covis::TrajectoryPose> trajectory = (*slam)->trajectory();
  for (const covis::TrajectoryPose& at : trajectory) {
    const covis::Pose& p = at.pose;
    std::printf("%.6f %.6f %.6f %.6f %.7f %.7f %.7f %.7f\n", at.stamp * 1e-9, p.x, p.y, p.z, p.qx, p.qy, p.qz, p.qw);
  }
  std::fprintf(stderr, "%zu of %zu images have a pose\n", trajectory.size(), files.size());
  return trajectory.empty() ? 1 : 0;
}
