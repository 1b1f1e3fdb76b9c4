// SPDX-License-Identifier: Apache-2.0
#include "covis/features/features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <tuple>

#include "covis/core/random.h"
#include "covis/features/extractor.h"
#include "covis/features/hamming.h"
#include "covis/features/orb.h"
#include "covis/features/simd.h"
#include "covis/features/test_images.h"
#include "covis/features/test_targets.h"

namespace covis {
namespace {

ImageU8 to_image(const cv::Mat& mat) {
  ImageU8 image(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) std::copy(mat.ptr(y), mat.ptr(y) + mat.cols, image.row(y));
  return image;
}

// The same pixels, as OpenCV takes them.
cv::Mat as_mat(ImageU8& image) {
  return {image.height(), image.width(), CV_8U, image.row(0), static_cast<size_t>(image.stride())};
}

// As soft as a lens makes it: OpenCV rounds its blur's weights otherwise, which a sharper image shows.
ImageU8 soft_texture(int width, int height, uint64_t seed) {
  ImageU8 image = texture(width, height, seed);
  cv::Mat mat = as_mat(image);
  cv::GaussianBlur(mat, mat, {5, 5}, 1);
  return image;
}

using Scored = std::set<std::tuple<int, int, int>>;

Scored by_opencv(const cv::Mat& image, int border, int threshold) {
  std::vector<cv::KeyPoint> points;
  cv::FAST(image, points, threshold, true, cv::FastFeatureDetector::TYPE_9_16);
  Scored found;
  for (const cv::KeyPoint& p : points) {
    const int x = static_cast<int>(p.pt.x), y = static_cast<int>(p.pt.y);
    if (x >= border && y >= border && x < image.cols - border && y < image.rows - border)
      found.emplace(y, x, static_cast<int>(p.response));
  }
  return found;
}

TEST(Fast, CornersAndScoresAreOpenCvs) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    ImageU8 ours = texture(200 + static_cast<int>(seed) * 13, 150, seed);
    cv::Mat image = as_mat(ours);
    if (seed > 3) cv::randu(image, 0, 256);
    for (const int threshold : {1, 7, 20, 60}) {
      FastDetector detector;
      std::vector<Corner> corners;
      detector.detect(ours.view(), 4, 30, threshold, threshold, corners);
      Scored found;
      for (const Corner& c : corners) found.emplace(c.y, c.x, c.score);
      EXPECT_EQ(found, by_opencv(image, 4, threshold)) << "seed " << seed << " threshold " << threshold;
    }
  }
}

TEST(Fast, LowThresholdServesCellsWithoutCornersOnly) {
  cv::Mat image(120, 240, CV_8U, cv::Scalar(100));
  image(cv::Rect(20, 20, 40, 40)) = 200;      // strong corners left
  image(cv::Rect(150, 40, 40, 40)) = 119;     // weak ones right
  image(cv::Rect(45, 90, 20, 20)) = 119;      // weak ones in another cell
  cv::GaussianBlur(image, image, {5, 5}, 1);  // perfect squares have two equal scores at a corner
  FastDetector detector;
  std::vector<Corner> corners;
  detector.detect(to_image(image).view(), 4, 30, 20, 7, corners);
  int strong = 0, weak = 0;
  for (const Corner& c : corners) ++(c.score >= 20 ? strong : weak);
  EXPECT_GE(strong, 4);
  EXPECT_GE(weak, 6);
  detector.detect(to_image(image).view(), 4, 240, 20, 7, corners);  // one cell: the strong ones silence the weak
  for (const Corner& c : corners) EXPECT_GE(c.score, 20);
}

TEST(Simd, ScoresAndMaximaAreTheScalarOnes) {
  Random random(3);
  for (int trial = 0; trial < 40; ++trial) {
    cv::Mat mat(7, 100 + trial, CV_8U);
    cv::randu(mat, 0, trial % 2 ? 256 : 60);
    const ImageU8 image = to_image(mat);
    const int count = mat.cols - 6, threshold = static_cast<int>(random.below(50));
    expect_scalar_twin([&] {
      std::vector<uint8_t> scores(static_cast<size_t>(count));
      fast_score_row(image.row(3) + 3, image.stride(), count, threshold, scores.data());
      return scores;
    });
    // Few grey levels: equal neighbours, which are no maxima, and rows of zeros.
    cv::randu(mat, 0, trial % 3 == 0 ? 256 : 4);
    if (trial % 5 == 0) mat.colRange(10, 90) = 0;
    const ImageU8 scores = to_image(mat);
    expect_scalar_twin([&] {
      std::vector<uint16_t> columns(static_cast<size_t>(count));
      columns.resize(static_cast<size_t>(
          local_maxima_row(scores.row(1) + 3, scores.row(2) + 3, scores.row(3) + 3, count, columns.data())));
      return columns;
    });
  }
}

std::vector<uint8_t> pixels(const ImageU8& image) {
  std::vector<uint8_t> all;
  for (int y = 0; y < image.height(); ++y) all.insert(all.end(), image.row(y), image.row(y) + image.width());
  return all;
}

TEST(Simd, PyramidAndBlurAreTheScalarOnes) {
  Random random(31);
  for (int trial = 0; trial < 60; ++trial) {
    cv::Mat mat(8 + static_cast<int>(random.below(30)), 5 + static_cast<int>(random.below(150)), CV_8U);
    cv::randu(mat, trial % 4 ? 0 : 255, 256);  // all white too: the greatest sums
    const ImageU8 image = to_image(mat);
    // Exactly the pixels, nothing readable behind them that a sanitizer would let pass.
    const std::vector<uint8_t> bare = pixels(image);
    const ImageView<const uint8_t> view{bare.data(), mat.cols, mat.rows, mat.cols};
    const double factor = random.uniform(1, 2.3);  // beyond what the groups of SIMD span as well
    const int width = std::max(1, static_cast<int>(mat.cols / factor)),
              height = std::max(1, static_cast<int>(mat.rows / factor));
    expect_scalar_twin([&] {
      ImageU8 small(width, height);
      BilinearResizer().resize(view, small.view());
      return pixels(small);
    });
    expect_scalar_twin([&] {
      ImageU8 blurred;
      GaussianBlur().apply(view, blurred);
      return pixels(blurred);
    });
  }
}

TEST(Simd, OrientationAndDescriptorsAreTheScalarOnes) {
  Random random(32);
  const ImageU8 image = texture(300, 200, 33);
  for (int trial = 0; trial < 500; ++trial) {
    const int x = kEdgeBorder + static_cast<int>(random.below(300 - 2 * kEdgeBorder)),
              y = kEdgeBorder + static_cast<int>(random.below(200 - 2 * kEdgeBorder));
    const uint8_t* pixel = image.row(y) + x;
    const auto angle = static_cast<float>(random.uniform(0, 2 * CV_PI));
    expect_scalar_twin(
        [&] { return std::pair(orientation(pixel, image.stride()), describe(pixel, image.stride(), angle)); });
  }
}

TEST(Pyramid, ResizeAndBlurAreOpenCvsWithinOneLevel) {
  ImageU8 ours = soft_texture(640, 480, 5);
  const cv::Mat image = as_mat(ours);
  ImageU8 small(533, 400);
  BilinearResizer resizer;
  resizer.resize(ours.view(), small.view());
  cv::Mat expected;
  cv::resize(image, expected, {533, 400}, 0, 0, cv::INTER_LINEAR);
  ImageU8 blurred;
  GaussianBlur().apply(ours.view(), blurred);
  cv::Mat expected_blur;
  cv::GaussianBlur(image, expected_blur, {7, 7}, 2, 2, cv::BORDER_REFLECT_101);
  for (int y = 0; y < 400; ++y) {
    for (int x = 0; x < 533; ++x) ASSERT_NEAR(small(x, y), expected.at<uint8_t>(y, x), 1);
  }
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) ASSERT_NEAR(blurred(x, y), expected_blur.at<uint8_t>(y, x), 1);
  }
}

// One level, so that both describe the same pixels.
TEST(Orb, OrientationAndDescriptorsAreOpenCvs) {
  int64_t bits = 0, different = 0;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    ImageU8 ours = soft_texture(640, 480, seed);
    const cv::Mat image = as_mat(ours);
    std::vector<cv::KeyPoint> points;
    cv::FAST(image, points, 20, true);
    const auto orb = cv::ORB::create(100000, 1.2f, 1, 31, 0, 2, cv::ORB::FAST_SCORE, 31, 20);
    cv::KeyPointsFilter::runByImageBorder(points, image.size(), 32);
    for (cv::KeyPoint& p : points) {
      p.octave = 0;
      p.size = 31;
      const float angle = orientation(ours.row(static_cast<int>(p.pt.y)) + static_cast<int>(p.pt.x), ours.stride());
      p.angle = angle * 180 / static_cast<float>(CV_PI);
    }
    cv::Mat expected;
    orb->compute(image, points, expected);
    ASSERT_GT(points.size(), 200u);
    ImageU8 blurred;
    GaussianBlur().apply(ours.view(), blurred);
    for (size_t i = 0; i < points.size(); ++i) {
      const int x = static_cast<int>(points[i].pt.x), y = static_cast<int>(points[i].pt.y);
      const Descriptor d =
          describe(blurred.row(y) + x, blurred.stride(), points[i].angle * static_cast<float>(CV_PI) / 180);
      Descriptor e;
      std::memcpy(e.bits.data(), expected.ptr(static_cast<int>(i)), 32);
      different += hamming(d, e);
      bits += 256;
    }
  }
  EXPECT_LT(static_cast<double>(different), 1e-3 * static_cast<double>(bits)) << different << " of " << bits;
}

TEST(Orb, OrientationFollowsTheImage) {
  ImageU8 image = texture(101, 101, 9), turned(101, 101);
  cv::Mat turned_mat = as_mat(turned);
  cv::rotate(as_mat(image), turned_mat, cv::ROTATE_90_CLOCKWISE);
  const float before = orientation(image.row(50) + 50, image.stride());
  const float after = orientation(turned.row(50) + 50, turned.stride());
  EXPECT_NEAR(std::remainder(after - before - CV_PI / 2, 2 * CV_PI), 0, 0.02);
}

std::vector<Corner> random_corners(Random& random, int count, int width, int height) {
  std::set<std::pair<int, int>> places;
  std::vector<Corner> corners;
  while (static_cast<int>(corners.size()) < count) {
    const int x = static_cast<int>(random.below(static_cast<uint32_t>(width))),
              y = static_cast<int>(random.below(static_cast<uint32_t>(height)));
    if (places.emplace(x, y).second)
      corners.push_back(
          {static_cast<int16_t>(x), static_cast<int16_t>(y), static_cast<uint8_t>(1 + random.below(255))});
  }
  return corners;
}

using Places = std::set<std::tuple<int, int, int>>;
Places places(const std::vector<Corner>& corners) {
  Places set;
  for (const Corner& c : corners) set.emplace(c.x, c.y, c.score);
  return set;
}

TEST(Quadtree, PropertiesHold) {
  Random random(4);
  Quadtree tree;
  std::vector<Corner> kept, again;
  for (int trial = 0; trial < 200; ++trial) {
    const int width = 40 + static_cast<int>(random.below(600)), height = 40 + static_cast<int>(random.below(400));
    const int count = static_cast<int>(random.below(900)), budget = static_cast<int>(random.below(300)) + 1;
    std::vector<Corner> corners = random_corners(random, std::min(count, width * height / 4), width, height);
    tree.distribute(corners, 0, 0, width, height, budget, kept);
    const int roots = std::max(1, static_cast<int>(std::lround(static_cast<double>(width) / height)));
    EXPECT_LE(static_cast<int>(kept.size()), std::max(budget + 3, roots));
    EXPECT_GE(static_cast<int>(kept.size()),
              std::min(budget, static_cast<int>(corners.size())));  // the wanted number is reached
    const Places input = places(corners), output = places(kept);
    EXPECT_EQ(output.size(), kept.size());
    EXPECT_TRUE(std::includes(input.begin(), input.end(), output.begin(), output.end()));
    for (size_t k = corners.size(); k > 1; --k)
      std::swap(corners[k - 1], corners[random.below(static_cast<uint32_t>(k))]);
    tree.distribute(corners, 0, 0, width, height, budget, again);
    EXPECT_EQ(places(again), output);
  }
}

TEST(Quadtree, ClusterEmptyAndBestOfANode) {
  Random random(5);
  Quadtree tree;
  std::vector<Corner> kept;
  tree.distribute({}, 0, 0, 640, 480, 100, kept);
  EXPECT_TRUE(kept.empty());
  std::vector<Corner> cluster = random_corners(random, 200, 20, 20);
  tree.distribute(cluster, 0, 0, 640, 480, 50, kept);
  EXPECT_GE(kept.size(), 50u);
  EXPECT_LE(kept.size(), 53u);
  tree.distribute(cluster, 0, 0, 640, 480, 1, kept);
  ASSERT_EQ(kept.size(), 1u);
  for (const Corner& c : cluster) EXPECT_GE(kept[0].score, c.score);
  tree.distribute(cluster, 0, 0, 20, 300, 20, kept);  // higher than wide
  EXPECT_GE(kept.size(), 20u);
}

TEST(Extractor, TheWantedNumberIsReached) {
  for (const auto& [width, height] : {std::pair{640, 480}, std::pair{1241, 376}, std::pair{320, 240}}) {
    const ImageU8 image = texture(width, height, 7);
    for (const int wanted : {300, 1000, 2000}) {
      OrbOptions options;
      options.features = wanted;
      OrbExtractor extractor(options);
      const KeyPoints& found = extractor.extract(image.view());
      size_t corners = 0;
      FastDetector detector;
      std::vector<Corner> all;
      for (int l = 0; l < 8; ++l) {
        detector.detect(extractor.level(l), kEdgeBorder, 30, 20, 7, all);
        corners += all.size();
      }
      EXPECT_GE(found.size() + 8, std::min<size_t>(static_cast<size_t>(wanted), corners)) << width << " " << wanted;
      EXPECT_LE(found.size(), static_cast<size_t>(wanted) + 3 * 8);
    }
  }
}

// Whole numbers and IEEE arithmetic alone lead to the places, so their hash is the same everywhere; angles and
// descriptors follow from them by the mathematics library's arc tangent, sine and cosine. A change of this value
// changes every trajectory.
TEST(Extractor, PlacesAreThoseOfEver) {
  uint64_t hash = 14695981039346656037u;  // FNV-1a
  const auto add = [&](uint64_t value) { hash = (hash ^ value) * 1099511628211u; };
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    Random random(seed);
    ImageU8 image(400 + 37 * static_cast<int>(seed), 300), blurred;
    std::fill(image.row(0), image.row(299) + image.stride(), uint8_t{128});
    for (int k = 0; k < 400; ++k) {
      const auto w = 3 + random.below(40), h = 3 + random.below(40), x = random.below(360), y = random.below(250);
      const auto grey = static_cast<uint8_t>(random.below(256));
      for (uint32_t row = y; row < y + h; ++row) std::fill_n(image.row(static_cast<int>(row)) + x, w, grey);
    }
    GaussianBlur().apply(image.view(), blurred);
    OrbExtractor extractor{OrbOptions{}};
    const KeyPoints& k = extractor.extract(blurred.view());
    for (size_t i = 0; i < k.size(); ++i) {
      add(std::bit_cast<uint32_t>(k.x[i]));
      add(std::bit_cast<uint32_t>(k.y[i]));
      add(k.level[i]);
    }
    add(k.size());
  }
  EXPECT_EQ(hash, 13400720980037767191u);
}

TEST(ScalePyramid, PredictsTheCeilingOfTheLogarithm) {
  const ScalePyramid pyramid(8, 1.2f);
  Random random(6);
  for (int k = 0; k < 2000; ++k) {
    const double ratio = std::exp(random.uniform(-1, 2.5));
    const double exact = std::log(ratio) / std::log(1.2);
    if (std::abs(exact - std::round(exact)) < 1e-4) continue;  // rounding decides there
    EXPECT_EQ(pyramid.predict_level(static_cast<float>(ratio), 1),
              std::clamp(static_cast<int>(std::ceil(exact)), 0, 7));
  }
}

// Keypoints anywhere in the image, or on a small spot of it and its corners.
Features spread_out(Random& random, int count, bool anywhere) {
  Features f;
  for (int i = 0; i < count; ++i) {
    const bool corner = !anywhere && i % 3 == 0;
    f.x.push_back(corner ? 640 * static_cast<float>(i % 2)
                         : static_cast<float>(random.uniform(anywhere ? -10 : 200, anywhere ? 650 : 230)));
    f.y.push_back(corner ? 480 * static_cast<float>(i % 4 / 2)
                         : static_cast<float>(random.uniform(anywhere ? -10 : 100, anywhere ? 490 : 110)));
    f.level.push_back(static_cast<uint8_t>(random.below(8)));
  }
  return f;
}

class FeatureGridWindows : public testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(FeatureGridWindows, FindWhatBruteForceFinds) {
  const auto& [count, anywhere] = GetParam();
  Random random(7);
  Features f = spread_out(random, count, anywhere);
  f.grid.build({-10, -10, 650, 490}, f.x, f.y);
  const FeatureGrid once = f.grid;
  f.grid.build({-10, -10, 650, 490}, f.x, f.y);  // a second build must replace all of the first
  EXPECT_EQ(f.grid.offsets, once.offsets);
  EXPECT_EQ(f.grid.indices, once.indices);
  EXPECT_LE(f.grid.offsets.size(), std::min(f.x.size(), FeatureGrid::kCells) + 1);
  for (int trial = 0; trial < 500; ++trial) {
    const float x = static_cast<float>(random.uniform(-60, 700)), y = static_cast<float>(random.uniform(-60, 540));
    const float radius = static_cast<float>(random.uniform(0.5, 80));
    const int low = static_cast<int>(random.below(8)), high = low + static_cast<int>(random.below(4));
    std::set<int> found, expected;
    f.for_each_in_window(x, y, radius, low, high, [&](int i) { EXPECT_TRUE(found.insert(i).second); });
    for (int i = 0; i < f.size(); ++i) {
      const auto k = static_cast<size_t>(i);
      if (f.level[k] >= low && f.level[k] <= high && std::abs(f.x[k] - x) <= radius && std::abs(f.y[k] - y) <= radius)
        expected.insert(i);
    }
    EXPECT_EQ(found, expected);
  }
}

// From none to more than there are cells.
INSTANTIATE_TEST_SUITE_P(Features, FeatureGridWindows,
                         testing::Combine(testing::Values(0, 1, 800, 9000), testing::Bool()));

// Cells by rows, keypoints of a cell as they come: matches that tie are decided by it.
TEST(FeatureGrid, WindowsVisitInAFixedOrder) {
  Random random(8);
  Features f = spread_out(random, 2000, true);
  const ImageBounds bounds{0, 0, 640, 480};  // some lie outside, and stand in the cells at the border
  f.grid.build(bounds, f.x, f.y);
  const auto place = [&](int i) {
    const auto k = static_cast<size_t>(i);
    const int c = std::clamp(static_cast<int>(f.x[k] / 10), 0, 63),
              r = std::clamp(static_cast<int>(f.y[k] / 10), 0, 47);
    return std::tuple(r, c, i);
  };
  std::vector<std::tuple<int, int, int>> visited;
  f.for_each_in_window(320, 240, 1000, 0, 7, [&](int i) { visited.push_back(place(i)); });
  EXPECT_EQ(visited.size(), f.x.size());
  EXPECT_TRUE(std::is_sorted(visited.begin(), visited.end()));
}

}  // namespace
}  // namespace covis
