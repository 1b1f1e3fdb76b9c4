// SPDX-License-Identifier: Apache-2.0
// That COLMAP itself reads the models is tests/exports/exports_test.py's.
#include "covis/exchange/colmap.h"

#include <Eigen/Geometry>
#include <map>
#include <sstream>

#include "covis/exchange/test_scene.h"

namespace covis::exchange {
namespace {

// Lines of a file without comments.
std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::istringstream text(read_file(file));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) {
    if (!line.starts_with("#")) lines.push_back(line);
  }
  return lines;
}

TEST(Colmap, AModelReadByItsFormatIsTheScene) {
  const TemporaryFolder folder;
  Scene scene = ring_scenes()[0];
  keep_tracks(scene);
  ASSERT_TRUE(write_colmap(folder / "sparse", scene));
  std::istringstream camera(lines_of(folder / "sparse/cameras.txt").at(0));
  std::string id, model;
  double width, height, fx, fy, cx, cy;
  camera >> id >> model >> width >> height >> fx >> fy >> cx >> cy;
  EXPECT_EQ(model, "PINHOLE");
  EXPECT_EQ(cx, scene.cameras[0].pinhole.cx + 0.5) << "the centre of COLMAP's first pixel is at 0.5";

  const std::vector<std::string> images = lines_of(folder / "sparse/images.txt");
  ASSERT_EQ(images.size(), 2 * scene.views.size());
  std::map<int, SE3> poses;
  std::map<int, std::vector<std::tuple<double, double, int>>> keypoints;
  for (size_t i = 0; i < images.size(); i += 2) {
    std::istringstream pose(images[i]), list(images[i + 1]);
    int image;
    double w, x, y, z, tx, ty, tz;
    pose >> image >> w >> x >> y >> z >> tx >> ty >> tz;
    poses[image] = SE3(Eigen::Quaterniond(w, x, y, z).toRotationMatrix(), {tx, ty, tz});
    double u, v;
    for (int point; list >> u >> v >> point;) keypoints[image].emplace_back(u, v, point);
  }
  int sights = 0;
  for (const std::string& line : lines_of(folder / "sparse/points3D.txt")) {
    std::istringstream text(line);
    int point, red, green, blue, image, at, seen = 0;
    double x, y, z, error;
    text >> point >> x >> y >> z >> red >> green >> blue >> error;
    for (; text >> image >> at; ++seen) {
      const auto [u, v, shown] = keypoints[image].at(static_cast<size_t>(at));
      EXPECT_EQ(shown, point);
      const Eigen::Vector3d p = poses[image] * Eigen::Vector3d(x, y, z);
      EXPECT_NEAR(fx * p.x() / p.z() + cx, u, 1e-2);
      EXPECT_NEAR(fy * p.y() / p.z() + cy, v, 1e-2);
    }
    EXPECT_GE(seen, 2);
    EXPECT_EQ((std::vector{red, green, blue}), (std::vector{200, 100, 50}));
    sights += seen;
  }
  EXPECT_GT(sights, 100);
}

TEST(Colmap, AFolderThatCantBeMadeIsNamed) {
  const TemporaryFolder folder;
  write_file(folder / "file", "");
  const auto written = write_colmap(folder / "file/sparse", ring_scenes()[0]);
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, testing::HasSubstr((folder / "file/sparse").string()));
}

}  // namespace
}  // namespace covis::exchange
