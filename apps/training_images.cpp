// SPDX-License-Identifier: Apache-2.0
#include "training_images.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <thread>
#include <utility>

#include "covis/features/extractor.h"
#include "covis/io/images.h"

namespace covis::app {
namespace {

namespace fs = std::filesystem;

constexpr int kSizes[] = {640, 1280, 2560};  // lengths of the longest side, pixels
constexpr int kPiece = 640;                  // approximate size of a piece, pixels
constexpr int kLeast = 160;                  // images with a shorter side give no useful pyramid

bool is_image_name(const fs::path& file) {
  static constexpr std::array<std::string_view, 9> kNames = {".bmp", ".jpeg", ".jpg",  ".pgm", ".png",
                                                             ".ppm", ".tif",  ".tiff", ".webp"};
  std::string name = file.extension().string();
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

// As the recordings that covis run reads name folders of depth images; 7-Scenes names the images,
// frame-000000.depth.png.
bool holds_depth(const fs::path& folder) {
  static constexpr std::array<std::string_view, 4> kNames = {"depth", "aligned_depth", "depth_left", "depth_right"};
  return std::find(kNames.begin(), kNames.end(), folder.filename().string()) != kNames.end();
}

Result<void> add_folder(const fs::path& folder, std::vector<fs::path>& files) {
  std::error_code error;
  std::vector<fs::path> found;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code none;  // links may lead nowhere
    if (it->is_directory(none) && holds_depth(it->path())) {
      it.disable_recursion_pending();
    } else if (it->is_regular_file(none) && is_image_name(it->path()) &&
               !it->path().stem().string().ends_with(".depth")) {
      found.push_back(it->path());
    }
  }
  if (error) return fail(folder.string() + ": the folder can't be read: " + error.message());
  if (found.empty()) return fail(folder.string() + ": the folder holds no images");
  std::sort(found.begin(), found.end());
  files.insert(files.end(), found.begin(), found.end());
  return {};
}

using Pieces = std::vector<std::vector<Descriptor>>;  // descriptors of each piece of an image

// Per-thread scratch memory and extractor.
class Worker {
 public:
  explicit Worker(const OrbOptions& options) : extractor_(options) {}

  Result<Pieces> extract(const fs::path& file) {
    if (auto read = reader_.grey(file, image_); !read) return tl::unexpected(read.error());
    const cv::Mat full(image_.height(), image_.width(), CV_8UC1, image_.row(0), static_cast<size_t>(image_.stride()));
    const int longest = std::max(full.cols, full.rows);
    Pieces pieces;
    for (const int size : kSizes) {
      const double scale = std::min(1.0, static_cast<double>(size) / longest);
      cv::Mat scaled = full;
      if (scale < 1) cv::resize(full, scaled, {}, scale, scale, cv::INTER_AREA);
      cut(scaled, pieces);
      if (scale >= 1) break;
    }
    if (pieces.empty()) {
      return fail(file.string() + ": " + std::to_string(full.cols) + "x" + std::to_string(full.rows) +
                  " pixels are too few: each side must have " + std::to_string(kLeast));
    }
    return pieces;
  }

 private:
  void cut(const cv::Mat& image, Pieces& pieces) {
    const int columns = std::max(1, (image.cols + kPiece / 2) / kPiece),
              rows = std::max(1, (image.rows + kPiece / 2) / kPiece);
    if (image.cols / columns < kLeast || image.rows / rows < kLeast) return;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        const int x = image.cols * c / columns, y = image.rows * r / rows;
        // The extractor needs readable memory behind the last row.
        piece_.resize(image.cols * (c + 1) / columns - x, image.rows * (r + 1) / rows - y);
        for (int row = 0; row < piece_.height(); ++row) {
          std::copy_n(image.ptr<uint8_t>(y + row) + x, piece_.width(), piece_.row(row));
        }
        const AlignedVector<Descriptor>& found = extractor_.extract(std::as_const(piece_).view()).descriptor;
        pieces.emplace_back(found.begin(), found.end());
      }
    }
  }

  io::ImageReader reader_;
  ImageU8 image_, piece_;
  OrbExtractor extractor_;
};

}  // namespace

Result<std::vector<fs::path>> find_images(const std::vector<std::string>& files_or_folders) {
  std::vector<fs::path> files;
  for (const std::string& name : files_or_folders) {
    std::error_code error;
    if (fs::is_directory(name, error)) {
      if (auto ok = add_folder(name, files); !ok) return tl::unexpected(ok.error());
    } else if (fs::exists(name, error)) {
      files.emplace_back(name);
    } else {
      return fail(name + ": there is no such file or folder");
    }
  }
  return files;
}

ExtractionReport extract_images(const std::vector<fs::path>& files, const OrbOptions& options, int threads,
                                TrainingSet& set, const std::function<bool(size_t)>& progress) {
  const size_t workers = threads > 0 ? static_cast<size_t>(threads) : std::max(1u, std::thread::hardware_concurrency());
  const size_t batch = 16 * workers;
  std::vector<std::unique_ptr<Worker>> worker;
  for (size_t w = 0; w < workers; ++w) worker.push_back(std::make_unique<Worker>(options));
  ExtractionReport report;
  for (size_t begin = 0; begin < files.size() && !report.stopped; begin += batch) {
    const size_t count = std::min(batch, files.size() - begin);
    std::vector<Result<Pieces>> results(count);
    std::atomic<size_t> next = 0;
    const auto work = [&](Worker& own) {
      for (size_t i = next++; i < count; i = next++) results[i] = own.extract(files[begin + i]);
    };
    std::vector<std::jthread> running;  // when one can't be started, the others are waited for
    for (size_t w = 1; w < workers; ++w) running.emplace_back(work, std::ref(*worker[w]));
    work(*worker[0]);
    for (std::jthread& thread : running) thread.join();
    for (const Result<Pieces>& pieces : results) {
      if (!pieces) report.skipped.push_back(pieces.error().message);
      if (!pieces) continue;
      for (const std::vector<Descriptor>& piece : *pieces) set.add_image(piece);
    }
    report.stopped = !progress(begin + count);
  }
  return report;
}

}  // namespace covis::app
