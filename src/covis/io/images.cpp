// SPDX-License-Identifier: Apache-2.0
#include "covis/io/images.h"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "covis/core/atomic_file.h"
#include "covis/io/codecs.h"
#include "covis/io/files.h"
#include "covis/io/image_bytes.h"
#include "covis/io/opencv_picture.h"
#include "covis/io/plugin.h"

namespace covis::io {
namespace {

// Hands out the memory of a matrix for the first image of its size and type, and other memory for all else. An image
// that is decoded into a matrix that was empty cannot be taken for what the memory held before: where a decoder gives
// up before it asks for memory, the matrix stays empty.
class ReusedMemory : public cv::MatAllocator {
 public:
  explicit ReusedMemory(cv::Mat memory) : memory_(std::move(memory)) {}

  cv::UMatData* allocate(int dims, const int* sizes, int type, void* data, size_t* step, cv::AccessFlag flags,
                         cv::UMatUsageFlags usage) const override {
    const bool fits = !given_ && !data && dims == 2 && !memory_.empty() && type == memory_.type() &&
                      sizes[0] == memory_.rows && sizes[1] == memory_.cols;
    if (fits) {
      given_ = true;
      data = memory_.data;
      step[0] = memory_.step[0];
      step[1] = memory_.elemSize();
    }
    return cv::Mat::getDefaultAllocator()->allocate(dims, sizes, type, data, step, flags, usage);
  }
  bool allocate(cv::UMatData* data, cv::AccessFlag flags, cv::UMatUsageFlags usage) const override {
    return cv::Mat::getDefaultAllocator()->allocate(data, flags, usage);
  }
  void deallocate(cv::UMatData* data) const override { cv::Mat::getDefaultAllocator()->deallocate(data); }

 private:
  const cv::Mat memory_;
  mutable bool given_ = false;
};

// True when the file may hold an image to be turned: it has an EXIF block that tells an orientation (tag 0x0112, a
// short) other than 1.
bool is_turned(std::string_view bytes) {
  // The chunk of a PNG may also be behind its pixels.
  const bool png = bytes.starts_with("\x89PNG");
  const std::string_view name = png ? std::string_view("eXIf") : std::string_view("Exif\0\0", 6);
  const size_t exif = bytes.substr(0, png ? bytes.size() : size_t{1} << 17).find(name);
  if (exif == std::string_view::npos) return bytes.starts_with("II*") || bytes.starts_with("MM");  // TIFF: not asked
  const std::string_view block = bytes.substr(exif + name.size(), 4096);
  const bool little = block.starts_with("II");
  const std::string_view tag(little ? "\x12\x01\x03\x00" : "\x01\x12\x00\x03", 4);
  const size_t at = block.find(tag);
  if (at == std::string_view::npos || at + 10 > block.size()) return false;
  return block[at + (little ? 8 : 9)] != 1;
}

// Reads and decodes a file.
Result<cv::Mat> decode_file(const std::filesystem::path& file, std::string& bytes, int flags, cv::Mat to,
                            const ExpectedSize& expected) {
  if (auto read = read_bytes(file, bytes); !read) return tl::unexpected(read.error());
  return decode_image(file.string(), bytes, flags, std::move(to), expected);
}

}  // namespace

Result<cv::Mat> decode_image(const std::string& name, std::string_view bytes, int flags, cv::Mat to,
                             const ExpectedSize& expected) {
  if (const auto problem = problem_of_image(bytes, expected)) return fail(name + ": " + *problem);
  if (bytes.size() > kLargestFile) return fail(name + ": the image file is too large");
  const auto codecs = plugin<CodecPlugin>();
  if (!codecs) return fail(name + ": " + codecs.error().message);
  const std::string plain = without_texts(bytes);
  if (!plain.empty()) {
    // The bytes behind the texts may be taken for another format where they stand now.
    if (const auto problem = problem_of_image(plain, expected)) return fail(name + ": " + *problem);
    bytes = plain;
  }
  // OpenCV reads one byte behind the last number of a picture in plain text (P1 to P3), which need not end its line.
  std::string ended;
  if (bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '3') bytes = ended.append(bytes) += '\n';
  const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
  const ReusedMemory memory(std::move(to));
  cv::Mat decoded;
  decoded.allocator = const_cast<ReusedMemory*>(&memory);
  try {
    (*codecs)->decode(buffer, flags, decoded);
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) return tl::unexpected(no_memory(name));
    decoded.release();
  }
  if (decoded.empty()) return fail(name + ": the image can't be decoded");
  decoded.allocator = nullptr;
  return decoded;
}

void depth_in_metres(const cv::Mat& stored, double scale, ImageF& depth) {
  constexpr uint16_t kNoDepth = 0xffff;  // the greatest value is none in 7-Scenes, or too far in other data sets
  depth.resize(stored.cols, stored.rows);
  const auto inverse = static_cast<float>(1 / scale);
  for (int y = 0; y < stored.rows; ++y) {
    float* out = depth.row(y);
    if (stored.type() == CV_16UC1) {
      const auto* in = stored.ptr<uint16_t>(y);
      for (int x = 0; x < stored.cols; ++x) out[x] = in[x] < kNoDepth ? static_cast<float>(in[x]) * inverse : 0.0f;
    } else {
      const auto* in = stored.ptr<float>(y);
      for (int x = 0; x < stored.cols; ++x) out[x] = in[x] > 0 && std::isfinite(in[x]) ? in[x] : 0.0f;
    }
  }
}

Result<void> ImageReader::grey(const std::filesystem::path& file, ImageU8& image) {
  const int flags = with_depth(cv::IMREAD_GRAYSCALE, bits_) | (unturned_ ? cv::IMREAD_IGNORE_ORIENTATION : 0);
  const auto decoded = decode_file(file, bytes_, flags, as_mat(image, CV_8UC1), expected_);
  if (!decoded) return tl::unexpected(decoded.error());
  if (!image.empty() && decoded->data == image.row(0)) return {};
  image.resize(decoded->cols, decoded->rows);
  in_eight_bits(*decoded, bits_).copyTo(as_mat(image, CV_8UC1));
  return {};
}

Result<Picture> read_picture(const std::filesystem::path& file, const ExpectedSize& expected) {
  std::string bytes;
  const auto decoded = decode_file(file, bytes, cv::IMREAD_ANYCOLOR, {}, expected);
  if (!decoded) return tl::unexpected(decoded.error());
  Picture picture = picture_of(*decoded);
  if (!is_turned(bytes)) picture.file = file;
  return picture;
}

bool may_have_colours(const std::filesystem::path& file) {
  // The PNG specification, section 11.2.2: the 26th byte is the colour type; 0 and 4 are grey.
  const auto head = read_head(file, 26);
  if (!head) return false;
  const bool png = head->size() == 26 && head->starts_with("\x89PNG\r\n\x1a\n");
  return !(png && ((*head)[25] == 0 || (*head)[25] == 4));
}

Result<std::string> picture_bytes(const std::filesystem::path& file, const Picture& picture) {
  if (picture.channels == 0) return fail(file.string() + ": there is no picture to write");
  const char* extension = file.extension() == ".jpg" ? ".jpg" : ".png";
  auto bytes = encode_image(extension, mat_of(picture), {cv::IMWRITE_JPEG_QUALITY, 95});
  if (!bytes) return fail(file.string() + ": " + bytes.error().message);
  return bytes;
}

Result<void> write_picture(const std::filesystem::path& file, const Picture& picture) {
  const auto bytes = picture_bytes(file, picture);
  if (!bytes) return tl::unexpected(bytes.error());
  return write_atomically(file, *bytes);
}

Result<void> ImageReader::depth(const std::filesystem::path& file, double scale, ImageF& depth) {
  const auto decoded = decode_file(file, bytes_, cv::IMREAD_UNCHANGED, as_mat(raw_, CV_16UC1), expected_);
  if (!decoded) return tl::unexpected(decoded.error());
  if (decoded->type() != CV_16UC1 && decoded->type() != CV_32FC1) {
    return fail(file.string() + ": a depth image must have one channel of 16 bits or of 32-bit float");
  }
  depth_in_metres(*decoded, scale, depth);
  raw_.resize(decoded->type() == CV_16UC1 ? decoded->cols : 0, decoded->rows);  // memory for the next image
  return {};
}

Result<Picture> ImageReader::picture(const std::filesystem::path& file) {
  if (bits_ == 16) return read_picture(file, expected_);
  const auto decoded = decode_file(file, bytes_, with_depth(cv::IMREAD_ANYCOLOR, bits_), {}, expected_);
  if (!decoded) return tl::unexpected(decoded.error());
  return picture_of(in_eight_bits(*decoded, bits_));
}

bool ImageReader::may_have_colours(const std::filesystem::path& file) { return io::may_have_colours(file); }

}  // namespace covis::io
