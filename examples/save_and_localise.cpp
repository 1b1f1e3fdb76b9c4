// SPDX-License-Identifier: Apache-2.0
// Makes a map of a folder of images, keeps it in a file, and locates single images in it, as another program would.
//   save_and_localise FOLDER FOCAL_LENGTH VOCABULARY MAP
#include "images.h"

int main(int argc, char** argv) {
  if (argc != 5) return fail("usage: save_and_localise FOLDER FOCAL_LENGTH VOCABULARY MAP");
  const std::vector<std::string> files = images_of(argv[1]);
  if (files.empty()) return fail(std::string(argv[1]) + ": no images in it");

  covis::SlamOptions options{
      .sensor = covis::SensorType::monocular,
      .camera = camera_of(read_grey(files[0]), std::atof(argv[2])),
      .timing = covis::Timing::deterministic,
      .vocabulary = argv[3],
  };
  {
    const auto slam = covis::Slam::create(options);
    if (!slam) return fail(slam.error());
    for (size_t i = 0; i < files.size(); ++i) {
      const cv::Mat image = read_grey(files[i]);
      const auto result = (*slam)->track({.stamp = static_cast<int64_t>(i) * 33'333'333, .image = view(image)});
      if (!result) return fail(files[i] + ": " + result.error());
    }
    (*slam)->finish();
    if (const auto saved = (*slam)->save_map(argv[4]); !saved) return fail(saved.error());
  }

  options.map = argv[4];
  options.mode = covis::Mode::localisation;  // the map is not changed
  const auto slam = covis::Slam::create(options);
  if (!slam) return fail(slam.error());
  int asked = 0, located = 0;
  for (size_t i = 0; i < files.size(); i += 10, ++asked) {
    const cv::Mat image = read_grey(files[i]);
    const auto place = (*slam)->locate({.image = view(image)});
    if (!place) return fail(files[i] + ": " + place.error());
    if (!*place) continue;
    ++located;
    const covis::Pose& p = (*place)->pose;
    std::printf("%s %.3f %.3f %.3f\n", files[i].c_str(), p.x, p.y, p.z);
  }
  std::fprintf(stderr, "%d of %d images located\n", located, asked);
  return located > 0 ? 0 : 1;
}
