// SPDX-License-Identifier: Apache-2.0
#include "covis/io/video_file.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "covis/io/files.h"
#include "covis/io/image_bytes.h"
#include "covis/io/plugin.h"

namespace covis::io {
namespace {

using namespace std::string_view_literals;

// Containers and streams whose pictures are in the file itself. FFmpeg would also open playlists, scripts and
// descriptions of streams, which name other files and addresses, and animated images of any size.
bool is_video(std::string_view head) {
  const auto begins = [&](size_t at, std::string_view text) {
    return head.substr(std::min(head.size(), at)).starts_with(text);
  };
  // MKV and WebM, Ogg, FLV, ASF, IVF, Y4M, MPEG program and video streams with H.264 and H.265, Motion JPEG
  for (const std::string_view first : {"\x1a\x45\xdf\xa3"sv, "OggS"sv, "FLV\1"sv, "\x30\x26\xb2\x75"sv, "DKIF"sv,
                                       "YUV4MPEG2 "sv, "\0\0\1"sv, "\0\0\0\1"sv, "\xff\xd8\xff"sv}) {
    if (begins(0, first)) return true;
  }
  for (const std::string_view atom : {"ftyp"sv, "moov"sv, "mdat"sv, "free"sv, "skip"sv, "wide"sv}) {  // MP4 and MOV
    if (begins(4, atom)) return true;
  }
  for (const auto& [first, packet] :
       {std::pair<size_t, size_t>{0, 188}, {4, 192}, {0, 204}}) {  // MPEG transport streams
    if (begins(first, "G") && begins(first + packet, "G") && begins(first + 2 * packet, "G")) return true;
  }
  return begins(8, "AVI ");
}

// Looks at the packets of Motion JPEG beside the decoder. Without a word it fills what is missing in a damaged one with
// the picture before, gives that in place of one of another size, and ends the video at one that is no JPEG.
class CheckedVideo : public VideoFile {
 public:
  CheckedVideo(std::unique_ptr<VideoFile> pictures, std::unique_ptr<VideoFile> packets)
      : properties_(pictures->properties()), pictures_(std::move(pictures)), packets_(std::move(packets)) {}

  Properties properties() const override { return properties_; }
  bool grab() override {
    decoded_ = pictures_->grab();
    const bool any = packets_->grab() && packets_->retrieve(packet_);
    if (!std::exchange(begun_, true)) checks_ = any && !is_damaged();
    checks_ = checks_ && (any || !decoded_);  // else they are no longer those of the pictures
    return decoded_ || (checks_ && any);
  }
  bool retrieve(cv::Mat& picture) override {
    return decoded_ && !(checks_ && is_damaged()) && pictures_->retrieve(picture);
  }
  double time() const override { return pictures_->time(); }

 private:
  bool is_damaged() const {
    const std::string_view bytes(reinterpret_cast<const char*>(packet_.data), packet_.total() * packet_.elemSize());
    return problem_of_image(bytes, {properties_.width, properties_.height, {}}).has_value();
  }

  const Properties properties_;
  const std::unique_ptr<VideoFile> pictures_, packets_;
  cv::Mat packet_;  // the last one that was grabbed
  bool decoded_ = false;
  bool begun_ = false;
  bool checks_ = false;  // the first packet is a whole JPEG file: some cameras leave out its end
};

}  // namespace

std::string limited_ffmpeg_options(const std::string& given) {
  const std::string limits =
      "protocol_whitelist;file|format_whitelist;mov,matroska,avi,ogg,flv,asf,ivf,yuv4mpegpipe,mpegts,mpeg,mpegvideo,"
      "m4v,h264,hevc,mjpeg,jpeg_pipe";
  // The last value of an option counts, but behind one that it does not understand FFmpeg reads none.
  return given.empty() ? limits : limits + "|" + given + "|" + limits;
}

void limit_ffmpeg() {
  static std::once_flag once;
  std::call_once(once, [] {
    constexpr const char* kName = "OPENCV_FFMPEG_CAPTURE_OPTIONS";
    const char* const given = std::getenv(kName);
    setenv(kName, limited_ffmpeg_options(given ? given : "").c_str(), 1);
  });
}

Result<std::unique_ptr<VideoFile>> open_video_file(const std::string& path) {
  const auto head = read_head(path, 1024);
  if (!head) return tl::unexpected(head.error());
  if (!is_video(*head)) {
    return fail(path +
                ": it is not a video that can be read (MP4, MOV, MKV, WebM, AVI, MPEG, Ogg, FLV, ASF, IVF, Y4M, H.264, "
                "H.265, Motion JPEG)");
  }
  const auto videos = plugin<VideoPlugin>();
  if (!videos) return tl::unexpected(videos.error());
  limit_ffmpeg();
  auto video = (*videos)->open_file(path, VideoPlugin::Give::pictures);
  if (!video) return video;
  const VideoFile::Properties properties = video->properties();
  if (int64_t{properties.width} * properties.height > kMostImagePixels) {
    return fail(path + ": its images are " + std::to_string(properties.width) + "x" +
                std::to_string(properties.height) + "; " + std::to_string(kMostImagePixels / 1'000'000) +
                " million pixels can be read");
  }
  if (!properties.motion_jpeg) return video;
  auto packets = (*videos)->open_file(path, VideoPlugin::Give::packets);
  if (!packets) return video;
  return std::make_unique<CheckedVideo>(std::move(video), std::move(packets));
}

}  // namespace covis::io
