// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/geojson.h"

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "covis/core/atomic_file.h"

namespace covis::exchange {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
// WGS 84: semi-major axis, metres, and the square of the eccentricity.
constexpr double kAxis = 6378137, kEccentricity2 = 6.69437999014e-3;

Eigen::Vector3d earth_centred(double latitude, double longitude, double altitude) {
  const double lat = latitude * kDegree, lon = longitude * kDegree;
  const double normal = kAxis / std::sqrt(1 - kEccentricity2 * std::sin(lat) * std::sin(lat));
  return {(normal + altitude) * std::cos(lat) * std::cos(lon), (normal + altitude) * std::cos(lat) * std::sin(lon),
          (normal * (1 - kEccentricity2) + altitude) * std::sin(lat)};
}

// Columns: east, north, up.
Eigen::Matrix3d local_axes(double latitude, double longitude) {
  const double lat = latitude * kDegree, lon = longitude * kDegree;
  Eigen::Matrix3d axes;
  axes << -std::sin(lon), -std::sin(lat) * std::cos(lon), std::cos(lat) * std::cos(lon),  //
      std::cos(lon), -std::sin(lat) * std::sin(lon), std::cos(lat) * std::sin(lon),       //
      0, std::cos(lat), std::sin(lat);
  return axes;
}

}  // namespace

// From earth-centred coordinates by fixed-point iteration on the latitude, which near the ground gains two digits a
// step.
Eigen::Vector3d place_on_earth(const GeoReference& reference, const Eigen::Vector3d& east_north_up) {
  const Eigen::Vector3d p = earth_centred(reference.latitude, reference.longitude, reference.altitude) +
                            local_axes(reference.latitude, reference.longitude) * east_north_up;
  const double from_axis = std::hypot(p.x(), p.y());
  double latitude = std::atan2(p.z(), from_axis * (1 - kEccentricity2)), altitude = 0;
  for (int i = 0; i < 8; ++i) {
    const double normal = kAxis / std::sqrt(1 - kEccentricity2 * std::sin(latitude) * std::sin(latitude));
    // There are two ways to the altitude; this one does not divide by a small number.
    altitude = std::cos(latitude) > 0.5 ? from_axis / std::cos(latitude) - normal
                                        : p.z() / std::sin(latitude) - normal * (1 - kEccentricity2);
    latitude = std::atan2(p.z() + kEccentricity2 * normal * std::sin(latitude), from_axis);
  }
  return {std::atan2(p.y(), p.x()) / kDegree, latitude / kDegree, altitude};
}

Result<void> write_geojson(const std::filesystem::path& file, const Scene& scene, const GeoReference& reference) {
  // x to the right and y ahead of the first view: turned so that y is north.
  const Eigen::Matrix3d to_enu =
      Eigen::AngleAxisd(-reference.heading * kDegree, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
      seen_from_above(scene);
  nlohmann::json line = nlohmann::json::array(), stamps = line, ids = line;
  for (const SceneView& view : scene.views) {
    const Eigen::Vector3d moved = view.T_cw.inverse().t() - scene.views.front().T_cw.inverse().t();
    const Eigen::Vector3d place = place_on_earth(reference, reference.scale * (to_enu * moved));
    line.push_back({place.x(), place.y(), place.z()});
    stamps.push_back(to_seconds(view.stamp));
    ids.push_back(view.serial);
  }
  const bool is_line = line.size() > 1;  // a line has two places at least
  nlohmann::json geometry{{"type", is_line ? "LineString" : "Point"}, {"coordinates", is_line ? line : line[0]}};
  const nlohmann::json path{{"type", "Feature"},
                            {"geometry", std::move(geometry)},
                            {"properties", {{"stamps_s", std::move(stamps)}, {"key_frames", std::move(ids)}}}};
  const nlohmann::json all{{"type", "FeatureCollection"}, {"features", nlohmann::json::array({path})}};
  return write_atomically(file, all.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

}  // namespace covis::exchange
