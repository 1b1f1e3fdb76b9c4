// SPDX-License-Identifier: Apache-2.0
#include "apps/calibrate/board_frames.h"

#include <filesystem>
#include <memory>
#include <utility>

#include "covis/core/log.h"
#include "covis/io/files.h"
#include "covis/io/images.h"
#include "covis/io/opencv_picture.h"
#include "covis/io/recording.h"
#include "covis/io/video_file.h"

namespace covis::app {
namespace {

namespace fs = std::filesystem;

// The images of a folder or a video, one after the other, in grey; every `stride`-th.
class Frames {
 public:
  static Result<Frames> open(const std::string& path) {
    Frames frames;
    if (fs::is_directory(path)) {
      frames.files_ = io::list_images(path);
      if (frames.files_.empty()) return fail(path + ": there are no images in this folder");
      return frames;
    }
    if (!fs::exists(path)) return fail(path + ": there is no such video or folder of images");
    if (!io::is_regular(path)) return fail(path + ": it is no regular file; a video or a folder of images is expected");
    auto video = io::open_video_file(path);
    if (!video) return tl::unexpected(video.error());
    if (!*video) return fail(path + ": it is neither a folder of images nor a video that can be read");
    frames.video_ = std::move(*video);
    frames.path_ = path;
    return frames;
  }
  bool is_video() const { return files_.empty(); }
  // False at the end. An image that can't be read is empty; what `grey` shows holds until the next call.
  bool next(cv::Mat& grey) {
    if (is_video()) {
      if (!video_->grab()) return false;
      if (video_->retrieve(picture_)) {
        io::to_grey(picture_, image_);
      } else {
        log(LogLevel::warning, path_ + ": frame " + std::to_string(at_) + " can't be decoded; it is passed over");
        image_ = {};
      }
    } else {
      if (at_ == files_.size()) return false;
      const auto read = reader_.grey(files_[at_], image_);
      if (!read) {
        log(LogLevel::warning, read.error().message + "; it is passed over");
        image_ = {};
      }
    }
    grey = io::as_mat(image_, CV_8UC1);
    ++at_;
    return true;
  }

 private:
  std::vector<fs::path> files_;
  std::unique_ptr<io::VideoFile> video_;
  std::string path_;  // the video's
  cv::Mat picture_;
  io::ImageReader reader_;
  ImageU8 image_;
  size_t at_ = 0;
};

}  // namespace

Result<BoardFrames> look_for_board(const std::string& path, const BoardFinder& finder, int stride,
                                   const std::atomic<int>& stop) {
  constexpr int kOfAVideo = 5;
  auto frames = Frames::open(path);
  if (!frames) return tl::unexpected(frames.error());
  if (stride == 0) stride = frames->is_video() ? kOfAVideo : 1;
  BoardFrames seen;
  cv::Mat grey;
  for (int64_t k = 0; stop == 0 && frames->next(grey); ++k) {
    if (grey.empty() || k % stride != 0) continue;
    if (seen.image.empty()) seen.image = grey.size();
    if (grey.size() != seen.image) {
      return fail(path + ": image " + std::to_string(k) + " is " + std::to_string(grey.cols) + "x" +
                  std::to_string(grey.rows) + ", those before " + std::to_string(seen.image.width) + "x" +
                  std::to_string(seen.image.height));
    }
    ++seen.frames;
    if (auto view = finder.find(grey)) {
      view->frame = k;
      seen.views.push_back(std::move(*view));
    }
  }
  return seen;
}

}  // namespace covis::app
