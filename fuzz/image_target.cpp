// SPDX-License-Identifier: Apache-2.0
// Image files: the checks that come before a decoder.
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "covis/io/image_bytes.h"
#include "target.h"

namespace covis::fuzz {
namespace {

void run_image(std::string_view bytes) {
  // A copy of its own, so that the sanitizer sees a read past its end.
  const std::vector<char> copy(bytes.begin(), bytes.end());
  const std::string_view image(copy.data(), copy.size());
  if (io::problem_of_image(image)) return;
  require(io::problem_of_image(image, {30000, 30000, "none"}).has_value(), "no image has a side that is too long");
  const std::string plain = io::without_texts(image);
  require(plain.size() < image.size(), "a PNG without its texts is shorter");
  require(plain.empty() || io::without_texts(plain).empty(), "a PNG without its texts has none");
  // The bytes behind the texts may be taken for another format where they stand now; decode_image() looks again.
  const auto stands = [&](size_t at, std::string_view word) {
    return plain.size() >= at + word.size() && plain.compare(at, word.size(), word) == 0;
  };
  require(plain.empty() || !io::problem_of_image(plain) || stands(128, "DICM") || stands(140, "DTED"),
          "a PNG without its texts has no problem but that of another format's word");
}

std::string encoded(const std::string& ending, const cv::Mat& image, const std::vector<int>& options = {}) {
  std::vector<uint8_t> bytes;
  cv::imencode(ending, image, bytes, options);
  return {bytes.begin(), bytes.end()};
}

std::vector<std::string> image_seeds() {
  cv::Mat image(19, 35, CV_8UC3);
  cv::RNG(1).fill(image, cv::RNG::UNIFORM, 90, 130);
  std::vector<std::string> seeds;
  for (const char* ending : {".png", ".tiff", ".bmp", ".ppm", ".webp"}) seeds.push_back(encoded(ending, image));
  for (const int progressive : {0, 1}) {
    for (const int restart : {0, 2}) {
      seeds.push_back(
          encoded(".jpg", image, {cv::IMWRITE_JPEG_PROGRESSIVE, progressive, cv::IMWRITE_JPEG_RST_INTERVAL, restart}));
    }
  }
  seeds.emplace_back("P2 # grey\n2 1\n255\n1 2\n");
  return seeds;
}

}  // namespace

std::vector<Target> image_targets() { return {{"images_bytes", run_image, image_seeds}}; }

}  // namespace covis::fuzz
