// SPDX-License-Identifier: Apache-2.0
// The path on the earth, for GIS programs and web maps (GeoJSON, RFC 7946).
#pragma once

#include <filesystem>
#include <vector>

#include "covis/core/error.h"
#include "covis/exchange/scene.h"

namespace covis::exchange {

// The place of the first key frame on WGS 84, and the direction it looked in. A map knows neither.
struct GeoReference {
  double latitude = 0, longitude = 0;  // degrees
  double altitude = 0;                 // metres above the ellipsoid
  double heading = 0;                  // degrees from north to east
  double scale = 1;                    // metres a unit of the map, for maps of one camera
};

// The place of a point given in metres to the east, to the north and above the reference: longitude, latitude,
// altitude.
Eigen::Vector3d place_on_earth(const GeoReference& reference, const Eigen::Vector3d& east_north_up);

// Writes the path of the key frames as one LineString (a Point for a single one), with their stamps (seconds) and ids
// as its properties.
Result<void> write_geojson(const std::filesystem::path& file, const Scene& scene, const GeoReference& reference);

}  // namespace covis::exchange
