// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/geojson.h"

#include <nlohmann/json.hpp>

#include "covis/exchange/test_scene.h"

namespace covis::exchange {
namespace {

// Lengths of a degree from the usual tables of WGS 84.
TEST(GeoJson, MetresAreDegreesAsTheTablesHaveThem) {
  const GeoReference equator{}, north{.latitude = 60, .longitude = 25, .altitude = 100};
  const Eigen::Vector3d east = place_on_earth(equator, {111.3195, 0, 0}), up = place_on_earth(north, {0, 0, 5});
  EXPECT_NEAR(east.x(), 0.001, 1e-8);
  EXPECT_NEAR(east.y(), 0, 1e-9);
  EXPECT_NEAR(place_on_earth(equator, {0, 110.574, 0}).y(), 0.001, 1e-8);
  EXPECT_NEAR(place_on_earth(north, {0, 111.412, 0}).y(), 60.001, 5e-8);
  EXPECT_NEAR(place_on_earth(north, {55.800, 0, 0}).x(), 25.001, 1e-7);
  EXPECT_TRUE(up.isApprox(Eigen::Vector3d(25, 60, 105), 1e-12));
}

TEST(GeoJson, ThePathBeginsAtTheReferenceAndGoesWhereItLooks) {
  const TemporaryFolder folder;
  Scene scene;
  for (const double ahead : {0.0, 10.0}) {
    SceneView& view = scene.views.emplace_back();
    view.T_cw = SE3(Eigen::Matrix3d::Identity(), {0, 0, -ahead});
    view.serial = static_cast<uint32_t>(ahead);
    view.stamp = from_seconds(ahead);
  }
  // Looks to the east; a unit of the map is two metres.
  ASSERT_TRUE(write_geojson(folder / "path.geojson", scene, {.heading = 90, .scale = 2}));
  const auto feature = nlohmann::json::parse(read_file(folder / "path.geojson"))["features"][0];
  EXPECT_EQ(feature["geometry"]["type"], "LineString");
  const auto& line = feature["geometry"]["coordinates"];
  EXPECT_NEAR(line[0][0].get<double>(), 0, 1e-12);
  EXPECT_NEAR(line[1][0].get<double>(), 20 / 111319.5, 1e-9);
  EXPECT_NEAR(line[1][1].get<double>(), 0, 1e-12);
  EXPECT_EQ(feature["properties"]["key_frames"], (nlohmann::json{0, 10}));
  EXPECT_EQ(feature["properties"]["stamps_s"][1], 10.0);
  scene.views.pop_back();
  ASSERT_TRUE(write_geojson(folder / "point.geojson", scene, {.latitude = 5, .longitude = 7}));
  const auto point = nlohmann::json::parse(read_file(folder / "point.geojson"))["features"][0]["geometry"];
  EXPECT_EQ(point["type"], "Point");
  EXPECT_NEAR(point["coordinates"][0].get<double>(), 7, 1e-12);
}

}  // namespace
}  // namespace covis::exchange
