// SPDX-License-Identifier: Apache-2.0
// Keypoints of one camera as another one would have them, so that key frames of several cameras are in one map, which
// has one camera. Keypoints are undistorted, so that this is exact: the same rays, in other pixels. A pixel of the old
// camera is then not one of the new camera, which the base of the pyramid says (ScalePyramid): the noise of keypoints
// and the levels at which points are expected follow from it.
#pragma once

#include "covis/core/error.h"
#include "covis/map/map_state.h"

namespace covis {

// Expresses all key frames of a map that `made_by` made in the pixels and the baseline of `to`. Poses, points and
// depths are those of before; a measured depth has the noise that the new camera's has. Key frames name their camera
// from then on (Features::made_by), unless it is `to` itself, refined in the same way. An error, and nothing done,
// where the pixels of one would be more than 64 times as large as those of the other, or images would lie beyond all
// bounds.
Result<void> express_in(MapState& map, const Camera& made_by, const RefinedCamera& to);

// The map's camera becomes this one, the same one refined in another way: keypoints are made free of its residual
// distortion. Poses and points stay, and fit the better the less the cameras differ.
void straighten(MapState& map, const Pinhole& camera);

// The cameras that key frames name, each once, in the order of their first key frames.
std::vector<RefinedCamera> other_cameras(const MapState& map);
inline constexpr size_t kMostCameras = 1000;  // greatest number of them that a map can have

// Some key frame names its camera, or has pixels of another size than the map's.
bool has_other_cameras(const MapState& map);
bool has_other_cameras(const Map& map);

// Some key frame was made by a camera with pixels of another size than the map's.
bool has_other_pixels(const MapState& map);

// The submaps in which a key frame has a measured depth, so that lengths are metres; rising.
std::vector<uint32_t> metric_submaps(const Map& map);

}  // namespace covis
