// SPDX-License-Identifier: Apache-2.0
#include "covis/features/depth_outlines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "covis/core/random.h"

namespace covis {
namespace {

constexpr int kImageWidth = 320, kImageHeight = 240;

struct Picture {
  ImageU8 grey{kImageWidth, kImageHeight};
  ImageF depth{kImageWidth, kImageHeight};
};

// Boxes of other greys in front of a wall with stripes, and their depth.
Picture boxes(uint64_t seed) {
  Random random(seed);
  Picture made;
  for (int y = 0; y < kImageHeight; ++y) {
    for (int x = 0; x < kImageWidth; ++x) {
      made.grey(x, y) = static_cast<uint8_t>(100 + (x / 9 % 2) * 12);
      made.depth(x, y) = 4;
    }
  }
  for (int box = 0; box < 6; ++box) {
    const int left = static_cast<int>(random.uniform(0, 280)), top = static_cast<int>(random.uniform(0, 200));
    const int right = std::min(kImageWidth, left + static_cast<int>(random.uniform(20, 90)));
    const int bottom = std::min(kImageHeight, top + static_cast<int>(random.uniform(20, 90)));
    const auto grey = static_cast<uint8_t>(random.uniform(0, 255));
    const auto depth = static_cast<float>(random.uniform(1, 3));
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        made.grey(x, y) = grey;
        made.depth(x, y) = depth;
      }
    }
  }
  return made;
}

// The answer for pictures whose depth at (x, y) is that of the place from(x, y); outside there is none.
template <class From>
OutlineFit fit_of(From from) {
  DepthOutlines outlines;
  std::optional<OutlineFit> answer;
  int frames = 0;
  while (!answer && frames < 100) {
    const Picture good = boxes(static_cast<uint64_t>(frames++));
    ImageF depth(kImageWidth, kImageHeight);
    for (int y = 0; y < kImageHeight; ++y) {
      for (int x = 0; x < kImageWidth; ++x) {
        const auto [u, v] = from(x, y);
        depth(x, y) = u >= 0 && v >= 0 && u < kImageWidth && v < kImageHeight ? good.depth(u, v) : 0;
      }
    }
    answer = outlines.add(good.grey.view(), depth.view());
  }
  EXPECT_EQ(frames, 5);
  return answer.value_or(OutlineFit{});
}

bool is_displaced(const OutlineFit& fit) { return fit.elsewhere > 8 && fit.ratio() > 2; }

TEST(DepthOutlines, RegisteredDepthIsNotDisplaced) {
  const OutlineFit fit = fit_of([](int x, int y) { return std::pair(x, y); });
  EXPECT_GT(fit.here, 12);
  EXPECT_LT(fit.ratio(), 1);
  EXPECT_FALSE(is_displaced(fit));
}

TEST(DepthOutlines, AFewPixelsAreNoDisplacement) {
  EXPECT_FALSE(is_displaced(fit_of([](int x, int y) { return std::pair(x - 9, y + 5); })));
}

TEST(DepthOutlines, DepthThatBelongsElsewhereIsDisplaced) {
  const auto displaced = [](auto from) { return is_displaced(fit_of(from)); };
  EXPECT_TRUE(displaced([](int x, int y) { return std::pair(x - kImageWidth / 8, y); })) << "shifted";
  EXPECT_TRUE(displaced([](int x, int y) { return std::pair(x, y + 40); })) << "lower";
  EXPECT_TRUE(displaced([](int x, int y) { return std::pair(kImageWidth - 1 - x, y); })) << "mirrored";
  EXPECT_TRUE(displaced([](int x, int y) { return std::pair(x, kImageHeight - 1 - y); })) << "upside down";
  EXPECT_TRUE(displaced([](int x, int y) { return std::pair(kImageWidth - 1 - x, kImageHeight - 1 - y); }))
      << "turned round";
  EXPECT_TRUE(displaced([](int x, int y) { return std::pair(kImageWidth / 4 + x / 2, kImageHeight / 4 + y / 2); }))
      << "twice as large";
  EXPECT_TRUE(displaced([](int x, int y) { return std::pair(160 + (x - 160) * 8 / 5, 120 + (y - 120) * 8 / 5); }))
      << "the wider view of a depth camera that is not registered";
}

TEST(DepthOutlines, AnAnswerSaysIfTheViewIsNew) {
  DepthOutlines outlines;
  const auto next = [&](uint64_t seed) {
    std::optional<OutlineFit> answer;
    while (!answer) answer = outlines.add(boxes(seed).grey.view(), boxes(seed).depth.view());
    return answer->new_view;
  };
  EXPECT_TRUE(next(1));
  EXPECT_FALSE(next(1));
  EXPECT_TRUE(next(2));
  EXPECT_TRUE(next(1));
}

TEST(DepthOutlines, DepthWithoutOutlinesSaysNothing) {
  const OutlineFit fit = fit_of([](int, int) { return std::pair(0, 0); });
  EXPECT_EQ(fit.here, 0);
  EXPECT_EQ(fit.elsewhere, 0);
  EXPECT_FALSE(is_displaced(fit));
}

// It has nothing in common with the image: no place fits.
TEST(DepthOutlines, DepthOfAnotherSceneIsNotCalledDisplaced) {
  DepthOutlines outlines;
  for (uint64_t i = 0; i < 40; ++i) {
    if (const auto fit = outlines.add(boxes(i).grey.view(), boxes(i + 1000).depth.view())) {
      EXPECT_FALSE(is_displaced(*fit));
      EXPECT_TRUE(fit->tells_much());
      EXPECT_LT(fit->here, 5);
    }
  }
}

// A floor that runs away from the camera: its depth doubles within some rows, but nothing ends there.
TEST(DepthOutlines, SurfacesAtASlantHaveNone) {
  DepthOutlines outlines;
  Picture floor = boxes(1);
  for (int y = 0; y < kImageHeight; ++y) {
    for (int x = 0; x < kImageWidth; ++x) floor.depth(x, y) = y > 40 ? 300.0f / static_cast<float>(y - 40) : 0;
  }
  std::optional<OutlineFit> answer;
  while (!answer) answer = outlines.add(floor.grey.view(), floor.depth.view());
  EXPECT_EQ(answer->outlines, 0);
}

TEST(DepthOutlines, ImagesSmallerThanTheCellsAreLookedAtPixelByPixel) {
  DepthOutlines outlines;
  ImageU8 grey(40, 30);
  ImageF depth(40, 30);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      grey(x, y) = x < 20 ? 20 : 200;
      depth(x, y) = x < 20 ? 1.0f : 3.0f;
    }
  }
  std::optional<OutlineFit> answer;
  while (!answer) answer = outlines.add(grey.view(), depth.view());
  ASSERT_TRUE(answer);
  EXPECT_GT(answer->here, 12);
  EXPECT_FALSE(is_displaced(*answer));
}

}  // namespace
}  // namespace covis
