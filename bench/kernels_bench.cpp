// SPDX-License-Identifier: Apache-2.0
// Micro-benchmarks of the kernels, on a procedural image and random problems, with cv::ORB for comparison.
#include <benchmark/benchmark.h>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "covis/core/random.h"
#include "covis/features/frontend.h"
#include "covis/features/hamming.h"
#include "covis/matching/descriptor_match.h"
#include "covis/optimization/bundle_adjustment.h"
#include "covis/optimization/pose_optimization.h"

namespace covis {
namespace {

cv::Mat texture(int width, int height) {
  Random random(1);
  cv::Mat image(height, width, CV_8U, cv::Scalar(128));
  for (int k = 0; k < width * height / 400; ++k) {
    const cv::Point at(static_cast<int>(random.below(static_cast<uint32_t>(width))),
                       static_cast<int>(random.below(static_cast<uint32_t>(height))));
    const cv::Size size(3 + static_cast<int>(random.below(40)), 3 + static_cast<int>(random.below(40)));
    cv::rectangle(image, cv::Rect(at, size), cv::Scalar(random.below(256)), cv::FILLED);
  }
  cv::GaussianBlur(image, image, {3, 3}, 0.8);
  return image;
}

Camera camera_of(const cv::Mat& image) {
  Camera camera;
  camera.width = image.cols;
  camera.height = image.rows;
  camera.pinhole = {500, 500, image.cols / 2.0, image.rows / 2.0, 50};
  return camera;
}

ImageView<const uint8_t> view(const cv::Mat& image) {
  return {image.data, image.cols, image.rows, static_cast<ptrdiff_t>(image.step)};
}

OrbOptions with_features(int64_t features) {
  OrbOptions options;
  options.features = static_cast<int>(features);
  return options;
}

void BM_Extract(benchmark::State& state) {
  const cv::Mat image = texture(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  Frontend frontend(camera_of(image), with_features(state.range(2)), Sensor::monocular);
  for (auto _ : state) benchmark::DoNotOptimize(frontend.monocular(view(image)));
}
BENCHMARK(BM_Extract)->Args({640, 480, 1000})->Args({1241, 376, 2000})->Unit(benchmark::kMillisecond);

void BM_ExtractOpenCv(benchmark::State& state) {
  cv::setNumThreads(1);
  const cv::Mat image = texture(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const auto orb = cv::ORB::create(static_cast<int>(state.range(2)), 1.2f, 8, 19, 0, 2, cv::ORB::FAST_SCORE, 31, 20);
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
  for (auto _ : state) orb->detectAndCompute(image, {}, points, descriptors);
}
BENCHMARK(BM_ExtractOpenCv)->Args({640, 480, 1000})->Args({1241, 376, 2000})->Unit(benchmark::kMillisecond);

void BM_Stereo(benchmark::State& state) {
  const cv::Mat left = texture(1241, 376);
  cv::Mat right;
  cv::warpAffine(left, right, cv::Mat((cv::Mat_<double>(2, 3) << 1, 0, -12.5, 0, 1, 0)), left.size());
  Frontend frontend(camera_of(left), with_features(2000), Sensor::stereo);
  double matching = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(frontend.stereo(view(left), view(right)));
    matching += frontend.timing().depth_ms;
  }
  state.counters["matching_ms"] = matching / static_cast<double>(state.iterations());
}
BENCHMARK(BM_Stereo)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_MatchDescriptors(benchmark::State& state) {
  const cv::Mat image = texture(640, 480);
  Frontend frontend(camera_of(image), {}, Sensor::monocular);
  const FeaturesPtr a = frontend.monocular(view(image));
  for (auto _ : state) benchmark::DoNotOptimize(match_descriptors(*a, {}, *a, {}, {}));
}
BENCHMARK(BM_MatchDescriptors)->Unit(benchmark::kMillisecond);

void BM_Pose(benchmark::State& state) {
  Random random(2);
  const Pinhole camera{500, 500, 320, 240, 40};
  PoseObservations observations;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p(random.uniform(-2, 2), random.uniform(-1.5, 1.5), random.uniform(2, 8));
    const Eigen::Vector2d pixel = camera.project(p);
    observations.add(p, static_cast<float>(pixel.x() + random.normal()),
                     static_cast<float>(pixel.y() + random.normal()), 1);
  }
  Vector6d off;
  off << 0.05, -0.05, 0.05, 0.02, -0.02, 0.01;
  std::vector<uint8_t> inlier;
  for (auto _ : state) benchmark::DoNotOptimize(optimize_pose(SE3::exp(off), observations, camera, {}, inlier));
}
BENCHMARK(BM_Pose)->Unit(benchmark::kMillisecond);

// Arguments: poses, points. Every point is observed from five consecutive poses.
void BM_BundleAdjustment(benchmark::State& state) {
  Random random(3);
  BundleProblem problem;
  problem.camera = {500, 500, 320, 240, 40};
  const auto poses = static_cast<int>(state.range(0)), points = static_cast<int>(state.range(1));
  for (int c = 0; c < poses; ++c) {
    problem.poses.emplace_back(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-0.2 * c, 0, 0));
    problem.fixed.push_back(c == 0);
  }
  for (int p = 0; p < points; ++p) {
    const int first = static_cast<int>(random.below(static_cast<uint32_t>(poses - 4)));
    const Eigen::Vector3d at(0.2 * (first + 2) + random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(4, 8));
    for (int c = first; c < first + 5; ++c) {
      const Eigen::Vector3d p_c = problem.poses[static_cast<size_t>(c)] * at;
      const Eigen::Vector2d pixel = problem.camera.project(p_c);
      BundleObservation o;
      o.pose = c;
      o.point = p;
      o.u = static_cast<float>(pixel.x() + random.normal());
      o.v = static_cast<float>(pixel.y() + random.normal());
      o.disparity = {static_cast<float>(problem.camera.bf / p_c.z() + random.normal()), 1};
      problem.observations.push_back(o);
    }
    problem.points.push_back(at + Eigen::Vector3d(0.05, -0.05, 0.1));
  }
  BundleAdjuster adjuster;
  for (auto _ : state) {
    BundleProblem copy = problem;
    benchmark::DoNotOptimize(adjuster.solve(copy, {.iterations = 5, .relative_cost_change = 0}));
  }
}
BENCHMARK(BM_BundleAdjustment)->Args({20, 2000})->Args({60, 6000})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace covis
