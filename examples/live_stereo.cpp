// SPDX-License-Identifier: Apache-2.0
// Two live cameras side by side that are not rectified, in real time. The library rectifies the pairs.
//   live_stereo LEFT RIGHT FOCAL_LENGTH BASELINE      LEFT, RIGHT: numbers of cameras, or what OpenCV can open besides
// A real rig has two cameras with a lens each and a turn between them: fill in what a calibration found.
#include <chrono>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "images.h"

namespace {

cv::VideoCapture open(const std::string& name) {
  const bool number = name.find_first_not_of("0123456789") == std::string::npos;
  return number ? cv::VideoCapture(std::atoi(name.c_str())) : cv::VideoCapture(name);
}

bool read(cv::VideoCapture& camera, cv::Mat& grey) {
  cv::Mat colour;
  if (!camera.read(colour)) return false;
  if (colour.channels() == 1) {
    grey = colour;
  } else {
    cv::cvtColor(colour, grey, cv::COLOR_BGR2GRAY);
  }
  return true;
}

int64_t now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return fail("usage: live_stereo LEFT RIGHT FOCAL_LENGTH BASELINE");
  cv::VideoCapture cameras[2] = {open(argv[1]), open(argv[2])};
  cv::Mat left, right;
  if (!read(cameras[0], left) || !read(cameras[1], right)) return fail("a camera gives no image");

  const covis::CameraParameters lens = camera_of(left, std::atof(argv[3]));
  covis::RightCamera beside{.camera = lens, .pose = {}};
  beside.pose.x = std::atof(argv[4]);  // metres to the right
  const auto slam = covis::Slam::create({
      .sensor = covis::SensorType::stereo,
      .camera = lens,
      .right = beside,
      .timing = covis::Timing::realtime,
  });
  if (!slam) return fail(slam.error());

  int frames = 0, tracked = 0;
  do {
    const auto result = (*slam)->track({.stamp = now(), .image = view(left), .right = view(right)});
    if (!result) return fail(result.error());
    ++frames;
    tracked += result->tracked();
    if (result->tracked()) {
      std::printf("%8.3f %8.3f %8.3f m\n", result->pose.x, result->pose.y, result->pose.z);
    } else {
      std::printf("%s: %s\n", covis::name(result->state), covis::describe(result->reason));
    }
  } while (read(cameras[0], left) && read(cameras[1], right));
  std::fprintf(stderr, "%d of %d pairs have a pose\n", tracked, frames);
  return tracked > 0 ? 0 : 1;
}
