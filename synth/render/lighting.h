// SPDX-License-Identifier: Apache-2.0
// Another light over a scene than the one that is painted into it: outdoors another sun with its shadows, indoors
// lamps, windows by day or night, and the patches that the sun throws through them. Things and their textures stay.
// Each polygon gets a light map, a lattice of brightnesses over its extent, from rays to the lights. Sources: Appel,
// "Some techniques for shading machine renderings of solids", SJCC 1968 (rays to the light); Cook, Porter, Carpenter,
// "Distributed ray tracing", SIGGRAPH 1984 (soft shadows from points spread over a light).
#pragma once

#include <cstdint>

#include "synth/render/camera_path.h"
#include "synth/render/scene.h"

namespace covis::synth {

// Replaces the scene's light by the one that `seed` selects. A scene with a sky gets a sun; one without gets lamps
// under its ceiling along the path, and daylight where polygons are marked as windows. The exposure is that of a camera
// on the path: what it sees is as bright as before in the mean.
void relight(Scene& scene, const CameraPath& path, uint64_t seed);

}  // namespace covis::synth
