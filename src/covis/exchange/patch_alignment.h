// SPDX-License-Identifier: Apache-2.0
// Keypoints to a fraction of a pixel, by the images. A keypoint is known to a pixel of its pyramid level, which may be
// four of the image. The surroundings of a point in the image that shows it finest are found again, to a tenth of such
// a pixel, in the others: least squares over a shift, the difference in brightness and contrast left out, after the
// surroundings were warped as the plane through the point that faces its observers is seen by both.
// Source: Baker, Matthews, "Lucas-Kanade 20 years on", IJCV 2004 (inverse compositional).
#pragma once

#include <cstddef>
#include <filesystem>

#include "covis/core/error.h"
#include "covis/exchange/scene.h"

namespace covis::exchange {

// Aligns the keypoints of each point by the views' images in a folder, which are those of the views' cameras
// (write_images()). A point whose surroundings are found in one other image at least loses the keypoints of those in
// which they are not; the number of these is returned. Keypoints of the other points, and the positions of all, stay.
// Error: an image that can't be read or is not of its camera's size.
Result<size_t> align_keypoints(Scene& scene, const std::filesystem::path& folder);

}  // namespace covis::exchange
