// SPDX-License-Identifier: Apache-2.0
// Whole imports are tests/exports/exports_test.py's.
#include "covis/exchange/colmap_import.h"

#include <gmock/gmock.h>

namespace covis::exchange {
namespace {

// The walk over images that share points would take the square of their number.
TEST(ColmapImport, PointsThatFarTooManyImagesShowAreRefused) {
  ColmapModel model;
  model.camera = {640, 480, {500, 500, 320, 240, 0}, Distortion::none, {}};
  for (int i = 0; i < 1100; ++i) model.images.push_back({"image.png", SE3(), {7}});
  SharedMap map(model.camera.pinhole);
  const auto made = import_colmap(model, "nowhere", {}, map);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, testing::HasSubstr("seen by 1100 images on average, more than 1000"));
}

}  // namespace
}  // namespace covis::exchange
