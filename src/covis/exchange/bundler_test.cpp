// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/bundler.h"

#include <sstream>

#include "covis/exchange/test_scene.h"

namespace covis::exchange {
namespace {

TEST(Bundler, ItsCamerasProjectItsPointsToTheirPixels) {
  const TemporaryFolder folder;
  Scene scene = centred(ring_scenes()[0]);
  keep_tracks(scene);
  ASSERT_TRUE(write_bundler(folder.path(), scene, "images"));
  std::istringstream text(read_file(folder / "bundle.out"));
  std::string head;
  std::getline(text, head);
  EXPECT_EQ(head, "# Bundle file v0.3");
  size_t cameras, points;
  text >> cameras >> points;
  ASSERT_EQ(cameras, scene.views.size());
  struct Camera {
    double f, k1, k2;
    Eigen::Matrix3d R;
    Eigen::Vector3d t;
  };
  std::vector<Camera> read(cameras);
  for (Camera& c : read) {
    text >> c.f >> c.k1 >> c.k2;
    for (int i = 0; i < 9; ++i) text >> c.R(i / 3, i % 3);
    for (int i = 0; i < 3; ++i) text >> c.t(i);
  }
  size_t sights = 0;
  for (size_t i = 0; i < points; ++i) {
    Eigen::Vector3d X;
    size_t views, view, key;
    int red, green, blue;
    double x, y;
    text >> X.x() >> X.y() >> X.z() >> red >> green >> blue >> views;
    EXPECT_EQ((std::vector{red, green, blue}), (std::vector{200, 100, 50}));
    for (size_t k = 0; k < views; ++k, ++sights) {
      text >> view >> key >> x >> y;
      const Camera& c = read.at(view);
      const Eigen::Vector3d P = c.R * X + c.t;  // the manual's formulas
      EXPECT_NEAR(c.f * -P.x() / P.z(), x, 1e-2);
      EXPECT_NEAR(c.f * -P.y() / P.z(), y, 1e-2);
    }
  }
  EXPECT_TRUE(text);
  EXPECT_GT(sights, 100u);
  EXPECT_THAT(read_file(folder / "list.txt"), testing::StartsWith("images/000000.png 0 500\n"));
}

}  // namespace
}  // namespace covis::exchange
