// SPDX-License-Identifier: Apache-2.0
#include "synth/render/texture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace covis::synth {
namespace {

TEST(Texture, EachLevelHasHalfTheSizeAndTheSameMean) {
  Canvas canvas(1, 0.5, 60, 100);
  canvas.fractal(0.2, 50, 3, 0.6, 7);
  const Texture texture(canvas);
  const TextureView view = texture.view();
  double first_mean = 0;
  for (int l = 0; l <= static_cast<int>(view.max_lod); ++l) {
    const int columns = static_cast<int>(view.columns[l]), rows = static_cast<int>(view.rows[l]);
    EXPECT_EQ(columns, static_cast<int>(std::ceil(60.0 / (1 << l))));
    EXPECT_EQ(rows, static_cast<int>(std::ceil(30.0 / (1 << l))));
    double sum = 0;
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) sum += view.texels[view.offset[l] + (y + 1) * view.stride[l] + x + 1];
    }
    if (l == 0) first_mean = sum / (columns * rows);
    EXPECT_NEAR(sum / (columns * rows), first_mean, 1.5) << l;
  }
  EXPECT_EQ(view.columns[static_cast<int>(view.max_lod)], 1);
  EXPECT_EQ(view.rows[static_cast<int>(view.max_lod)], 1);
}

TEST(Texture, TheBorderRepeatsTheEdge) {
  Canvas canvas(1, 1, 8, 0);
  canvas.grain(120, 3);
  const Texture texture(canvas);
  const TextureView v = texture.view();
  const auto texel = [&](int x, int y) { return v.texels[v.offset[0] + (y + 1) * v.stride[0] + x + 1]; };
  for (int k = 0; k < 8; ++k) {
    EXPECT_EQ(texel(-1, k), texel(0, k));
    EXPECT_EQ(texel(8, k), texel(7, k));
    EXPECT_EQ(texel(9, k), texel(7, k));
    EXPECT_EQ(texel(k, -1), texel(k, 0));
    EXPECT_EQ(texel(k, 9), texel(k, 7));
  }
}

}  // namespace
}  // namespace covis::synth
