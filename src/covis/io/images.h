// SPDX-License-Identifier: Apache-2.0
// Reading of image files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/image.h"
#include "covis/io/image_bytes.h"
#include "covis/types.h"

namespace covis::io {

// An image as people look at it: grey, or red, green and blue. Rows follow each other without gaps.
struct Picture {
  int width = 0, height = 0, channels = 0;  // channels: 1 or 3; 0: there is no picture
  std::vector<uint8_t> bytes;
  std::filesystem::path file = {};  // an image file that holds just this picture; empty: there is none

  bool coloured() const { return channels == 3; }
  uint8_t* row(int y) { return bytes.data() + static_cast<size_t>(y) * row_bytes(); }
  const uint8_t* row(int y) const { return bytes.data() + static_cast<size_t>(y) * row_bytes(); }
  size_t row_bytes() const { return static_cast<size_t>(width) * static_cast<size_t>(channels); }
  // Valid for a coloured one.
  ColourImage colours() const { return {bytes.data(), width, height, static_cast<ptrdiff_t>(row_bytes())}; }
};

// True when a file's name ends like that of an image that can be read, and is not hidden.
bool is_image(const std::filesystem::path& file);
// False when the head of an image file says that it is grey; true when it does not say.
bool may_have_colours(const std::filesystem::path& file);
// Images are turned upright as their EXIF orientation says, as they are for tracking. Picture::file is set where the
// file holds the picture as it is, not turned.
Result<Picture> read_picture(const std::filesystem::path& file, const ExpectedSize& expected = {});
// The bytes of a PNG, or of a JPEG of quality 95, as the ending of this name says.
Result<std::string> picture_bytes(const std::filesystem::path& file, const Picture& picture);
// Writes them; completely or not at all.
Result<void> write_picture(const std::filesystem::path& file, const Picture& picture);
// Calls resample(from, to) for each channel, and returns what it made, of one size for all.
template <class Resample>
Picture resampled(const Picture& picture, Resample&& resample) {
  Picture made;
  ImageU8 from(picture.width, picture.height), to;
  for (int channel = 0; channel < picture.channels; ++channel) {
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) from.row(y)[x] = picture.row(y)[picture.channels * x + channel];
    }
    resample(ImageView<const uint8_t>(from.view()), to);
    made.width = to.width();
    made.height = to.height();
    made.channels = picture.channels;
    made.bytes.resize(made.row_bytes() * static_cast<size_t>(made.height));
    for (int y = 0; y < made.height; ++y) {
      for (int x = 0; x < made.width; ++x) made.row(y)[made.channels * x + channel] = to.row(y)[x];
    }
  }
  return made;
}

// Reads the images of a recording by their names. Not thread-safe.
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  // From now on images of another size are refused before they are decoded.
  virtual void expect(const ExpectedSize& size) = 0;
  // From now on images of 16 bits are those of a camera that fills so many of them, the lowest ones.
  virtual void use_bits(int bits) = 0;
  // Reads grey values. Of 16 bits the upper 8 of those that are used are kept.
  virtual Result<void> grey(const std::filesystem::path& name, ImageU8& image) = 0;
  // Reads depth in metres: 16-bit images are divided by `scale` (units per metre), 32-bit float images are used as they
  // are. Negative and non-finite depths, and 65535 of 16 bits, are stored as 0 (no measurement).
  virtual Result<void> depth(const std::filesystem::path& name, double scale, ImageF& depth) = 0;
  virtual Result<Picture> picture(const std::filesystem::path& name) = 0;
  // False when picture() would give a grey image.
  virtual bool may_have_colours(const std::filesystem::path& name) = 0;
};

// Reads image files into reused memory: in the steady state only the decoders allocate memory of an image's size.
class ImageReader : public ImageSource {
 public:
  void expect(const ExpectedSize& size) override { expected_ = size; }
  void use_bits(int bits) override { bits_ = bits; }
  // From now on grey images stay as they are stored, whatever their EXIF orientation says.
  void leave_unturned() { unturned_ = true; }
  // Colour is converted on decoding (JPEG: the stored luma). Fails for a file that is missing, truncated or no image.
  Result<void> grey(const std::filesystem::path& file, ImageU8& image) override;
  // 32-bit float files are TIFF.
  Result<void> depth(const std::filesystem::path& file, double scale, ImageF& depth) override;
  Result<Picture> picture(const std::filesystem::path& file) override;
  bool may_have_colours(const std::filesystem::path& file) override;

 protected:
  const ExpectedSize& expected() const { return expected_; }

 private:
  ExpectedSize expected_;
  int bits_ = 16;
  bool unturned_ = false;
  std::string bytes_;    // contents of the file
  Image<uint16_t> raw_;  // depth as stored in the file
};

}  // namespace covis::io
