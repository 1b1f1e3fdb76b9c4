// SPDX-License-Identifier: Apache-2.0
#include "covis/io/image_bytes.h"

#include <opencv2/imgproc.hpp>

#include "covis/io/images.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string encoded(const std::string& ending, const cv::Mat& image) {
  std::vector<uint8_t> bytes;
  EXPECT_TRUE(cv::imencode(ending, image, bytes));
  return {bytes.begin(), bytes.end()};
}
std::string flat(const std::string& ending, int width = kWidth, int height = kHeight) {
  return encoded(ending, cv::Mat(height, width, CV_8UC3, cv::Scalar::all(100)));
}
std::string problem(const std::string& bytes, const ExpectedSize& expected = {}) {
  return problem_of_image(bytes, expected).value_or("");
}
std::string with(std::string bytes, size_t at, const std::string& other) {
  return bytes.replace(at, other.size(), other);
}

// The CRC of the PNG specification, annex D.
std::string chunk(const std::string& name, const std::string& data) {
  uint32_t crc = ~0u;
  for (const char c : name + data) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
  }
  const auto number = [](size_t value) {
    std::string bytes;
    for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(value >> shift);
    return bytes;
  };
  return number(data.size()) + name + data + number(~crc);
}

// Their decoders make copies in the folder for temporary files, open what the bytes name, or write to stderr.
TEST(ImageBytes, OtherFormatsAreRefusedByName) {
  const std::string space(200, ' ');
  for (const std::string& bytes :
       {std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 8\n"), std::string("Pf\n8 8\n-1\n"),
        std::string("P7\nWIDTH 8\n"), "\x59\xa6\x6a\x95" + space, "\x76\x2f\x31\x01" + space,
        std::string("\0\0\0\x0cjP  \r\n\x87\n", 12) + space, "NITF02.10" + space, with(space, 128, "DICM"),
        with("<VRTDataset" + space, 140, "DTED"), "GIF89a" + space, std::string("P5"), std::string("II*"),
        std::string("MM\0*", 3), std::string("RIFF"), std::string("P5#\n1 1\n255\n1")}) {
    EXPECT_FALSE(problem(bytes).empty()) << bytes;
    if (bytes.size() > 10) {
      EXPECT_THAT(problem(bytes), HasSubstr("(PNG, JPEG, TIFF, BMP, PBM, PGM, PPM, WebP)")) << bytes;
    }
  }
  EXPECT_THAT(problem(std::string("II\x2b\0\x08\0\0\0", 8)), HasSubstr("BigTIFF"));
  const std::string bmp = flat(".bmp");
  EXPECT_EQ(problem(bmp), "");
  EXPECT_THAT(problem(with(bmp, 14, "\x0c")), HasSubstr("OS/2"));
  EXPECT_THAT(problem(with(bmp, 30, "\x01")), HasSubstr("compression is 1"));
  for (const char* ending : {".png", ".jpg", ".tiff", ".bmp", ".ppm", ".webp"}) {
    EXPECT_EQ(problem(flat(ending)), "") << ending;
    EXPECT_NE(problem(with(flat(ending) + space, 140, "DTED")), "") << ending;
  }
}

TEST(ImageBytes, TheSignatureIsThatOfTheDecoder) {
  const std::string png = flat(".png"), jpeg = flat(".jpg"), pgm = "P5 2 1 255\nab";
  for (size_t at = 4; at < 8; ++at) EXPECT_NE(problem(with(png, at, "x")), "") << at;
  EXPECT_NE(problem(with(jpeg, 2, "x")), "");
  EXPECT_EQ(problem(pgm), "");
  EXPECT_NE(problem(with(pgm, 2, "#")), "");
}

TEST(ImageBytes, TheSizeMustBeThatOfTheCamera) {
  const ExpectedSize upright{kWidth, kHeight, "cam.yaml"}, turned{kHeight, kWidth, "cam.yaml"},
      other{640, 480, "cam.yaml"};
  for (const char* ending : {".png", ".jpg", ".tiff", ".bmp", ".ppm", ".webp"}) {
    EXPECT_EQ(problem(flat(ending), upright), "") << ending;
    EXPECT_EQ(problem(flat(ending), turned), "") << "its orientation may say so: " << ending;
    EXPECT_EQ(problem(flat(ending), other), "the image is 64x48, the camera of cam.yaml is 640x480") << ending;
  }
  EXPECT_THAT(problem("P4 20000 20000\n"), HasSubstr("100 million pixels"));
  EXPECT_THAT(problem("P4 20000 5000\n"), HasSubstr("cut short"));
}

TEST(ImageBytes, TheFirstOfTwoSizesOfATiffCounts) {
  std::string tiff = flat(".tiff");
  const size_t height = tiff.find(std::string("\x01\x01\x03\0\x01\0\0\0", 8));
  ASSERT_NE(height, std::string::npos);
  EXPECT_NE(problem(with(tiff, height, std::string(1, '\0'))), "") << "two widths and no height";
}

std::string progressive_jpeg() {
  std::vector<uint8_t> bytes;
  cv::imencode(".jpg", cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(100)), bytes,
               {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  return {bytes.begin(), bytes.end()};
}

TEST(ImageBytes, WhatIsBehindAJpegIsNoScanOfIt) {
  std::string behind;
  for (int i = 0; i < 200; ++i) behind += "raw \xff\xda ";
  for (const std::string& jpeg : {flat(".jpg"), progressive_jpeg()}) {
    EXPECT_EQ(problem(jpeg + behind), "");
    EXPECT_EQ(problem(jpeg + behind + "\xff\xd9"), "");
  }
}

TEST(ImageBytes, AJpegHasOneSize) {
  for (const std::string& jpeg : {flat(".jpg"), progressive_jpeg()}) {
    const size_t frame = std::min(jpeg.find("\xff\xc0"), jpeg.find("\xff\xc2"));
    ASSERT_NE(frame, std::string::npos);
    const std::string large = with(jpeg.substr(frame, 19), 5, "\x20\x20\x20\x20");
    EXPECT_THAT(problem(std::string(jpeg).insert(frame, large)), HasSubstr("its size twice"));
    EXPECT_THAT(problem(std::string(jpeg).insert(frame, jpeg.substr(frame, 19))), HasSubstr("its size twice"));
  }
}

TEST(ImageBytes, AJpegOfAbsurdlyManyScansIsRefused) {
  std::string jpeg = progressive_jpeg();
  const size_t last = jpeg.rfind("\xff\xda");
  const std::string scan = jpeg.substr(last, jpeg.size() - 2 - last);
  for (int i = 0; i < 100; ++i) jpeg.insert(last, scan);
  EXPECT_THAT(problem(jpeg), HasSubstr("more scans"));
}

TEST(ImageBytes, ThePartOfAProgressiveJpegThatIsDamagedIsReported) {
  int all = 0, noticed = 0;
  for (const cv::Size size : {cv::Size(64, 48), cv::Size(67, 41), cv::Size(16, 200), cv::Size(301, 205)}) {
    for (const int type : {CV_8UC3, CV_8UC1}) {
      for (const int restart : {0, 3}) {
        for (const double blur : {0.0, 2.0, 6.0}) {
          cv::Mat image(size, type);
          cv::RNG(1).fill(image, cv::RNG::UNIFORM, 0, 255);
          if (blur > 0) cv::GaussianBlur(image, image, {}, blur);
          std::vector<uint8_t> bytes;
          cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_PROGRESSIVE, 1, cv::IMWRITE_JPEG_RST_INTERVAL, restart});
          const std::string whole(bytes.begin(), bytes.end());
          SCOPED_TRACE(testing::Message() << size << " " << type << " " << restart << " " << blur);
          EXPECT_EQ(problem(whole), "");
          EXPECT_EQ(problem(whole + "behind"), "");
          for (size_t at = whole.find("\xff\xda"); at != std::string::npos; at = whole.find("\xff\xda", at + 1)) {
            const size_t data = at + 4 + static_cast<size_t>(whole[at + 3]), end = whole.find("\xff\xc4", data);
            const size_t length = std::min(end, whole.size() - 2) - data;
            if (length < 400) continue;
            all += 2;
            noticed += problem(whole.substr(0, data + length / 2) + "\xff\xd9") != "";
            noticed += problem(with(whole, data + length / 3, std::string(length / 3, '\0'))) != "";
          }
        }
      }
    }
  }
  EXPECT_GT(all, 100);
  EXPECT_GE(noticed, all * 9 / 10) << "of " << all;
}

TEST(ImageBytes, ThePartOfATiffThatIsDamagedIsReported) {
  int all = 0, zeroed = 0;
  for (const cv::Size size : {cv::Size(64, 48), cv::Size(301, 205)}) {
    for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1, CV_32FC1}) {
      for (const int compression : {1, 5, 8, 32773}) {
        for (const int noise : {8, 40, 255}) {
          SCOPED_TRACE(testing::Message() << size << " " << type << " " << compression << " " << noise);
          cv::Mat image(size, type);
          cv::RNG(1).fill(image, cv::RNG::UNIFORM, 0, noise);
          std::vector<uint8_t> bytes;
          cv::imencode(".tiff", image, bytes, {cv::IMWRITE_TIFF_COMPRESSION, compression});
          const std::string whole(bytes.begin(), bytes.end());
          EXPECT_EQ(problem(whole), "");
          if (compression == 1 || type == CV_32FC1) continue;  // it is not compressed
          ++all;
          zeroed += problem(with(whole, 8, std::string(whole.size() / 3, '\0'))) != "";
        }
      }
    }
  }
  EXPECT_GE(zeroed, all * 9 / 10) << "of " << all;
}

// A TIFF of 4x2 pixels whose strips are rows.
std::string tiff_of(const std::vector<uint32_t>& places, const std::vector<uint32_t>& lengths) {
  const auto number = [](size_t value, int bytes) {
    std::string text;
    for (int k = 0; k < bytes; ++k) text += static_cast<char>(value >> 8 * k);
    return text;
  };
  constexpr size_t kEntries = 7, kLists = 16 + 2 + 12 * kEntries + 4;
  const auto entry = [&](int tag, size_t count, size_t value) {
    return number(static_cast<size_t>(tag), 2) + number(4, 2) + number(count, 4) + number(value, 4);
  };
  std::string tiff = std::string("II*\0\x10\0\0\0", 8) + "pixels.." + number(kEntries, 2) + entry(256, 1, 4) +
                     entry(257, 1, 2) + entry(258, 1, 8) + entry(259, 1, 1) + entry(273, places.size(), kLists) +
                     entry(278, 1, 1) + entry(279, lengths.size(), kLists + 4 * places.size()) + number(0, 4);
  for (const std::vector<uint32_t>& list : {places, lengths}) {
    for (const uint32_t value : list) tiff += number(value, 4);
  }
  return tiff;
}

TEST(ImageBytes, TheStripsOfATiffThatTheImageHasAreLookedAt) {
  EXPECT_EQ(problem(tiff_of({8, 12}, {4, 4})), "");
  EXPECT_EQ(problem(tiff_of({8, 12, 1'000'000}, {4, 4, 4})), "") << "it has two rows";
  EXPECT_THAT(problem(tiff_of({8, 1'000'000}, {4, 4})), HasSubstr("cut short"));
  EXPECT_THAT(problem(tiff_of({8, 8}, {100, 100})), HasSubstr("strips or tiles overlap"));
}

class ImageFiles : public RecordingTest {};

TEST_F(ImageFiles, TheTextsOfAPngAreNotUnpacked) {
  const std::string plain = flat(".png"), begin = plain.substr(0, 33), rest = plain.substr(33);
  EXPECT_EQ(without_texts(plain), "");
  EXPECT_EQ(without_texts(flat(".jpg")), "");
  const std::string text = chunk("zTXt", "k") + chunk("iTXt", "") + chunk("tEXt", "Title");
  const std::string png = begin + text + chunk("gAMA", std::string("\0\0\xb1\x8f", 4)) + rest;
  EXPECT_EQ(problem(png), "");
  EXPECT_EQ(without_texts(png), begin + chunk("tEXt", "Title") + chunk("gAMA", std::string("\0\0\xb1\x8f", 4)) + rest);
  write("a.png", png);
  ImageU8 grey;
  EXPECT_TRUE(ImageReader().grey(folder / "a.png", grey));
  EXPECT_EQ(grey(3, 3), 100);
}

// Found by tools/fuzz: OpenCV takes bytes with this word at this place for another format.
TEST_F(ImageFiles, ATextOfAPngHidesNoOtherFormat) {
  constexpr size_t kHead = 33, kBefore = 8, kWord = 140;  // bytes: up to the first chunk, before its data, to the word
  const std::string plain = flat(".png"), rest = plain.substr(kHead);
  const std::string word = chunk("tEXt", std::string(kWord - kHead - kBefore, '.') + "DTED");
  const std::string png = plain.substr(0, kHead) + chunk("zTXt", "k") + word + rest;
  EXPECT_EQ(problem(png), "");
  write("a.png", png);
  ImageU8 grey;
  EXPECT_THAT(ImageReader().grey(folder / "a.png", grey).error().message,
              AllOf(HasSubstr("a.png"), HasSubstr("not an image that can be read")));
}

TEST_F(ImageFiles, WebPIsRead) {
  write("a.webp", flat(".webp"));
  ImageU8 grey;
  ASSERT_TRUE(ImageReader().grey(folder / "a.webp", grey));
  EXPECT_EQ(grey.width(), kWidth);
  EXPECT_NEAR(grey(3, 3), 100, 2);
  write("a.webp", flat(".webp").substr(0, 40));
  EXPECT_THAT(ImageReader().grey(folder / "a.webp", grey).error().message,
              AllOf(HasSubstr("a.webp"), HasSubstr("cut short")));
}

// Only its header is read: the data behind it are none.
TEST_F(ImageFiles, AnImageOfAnotherSizeIsNotDecoded) {
  tum();
  const std::string large = flat(".png", 900, 700);
  write("rgb/1.png", large.substr(0, 33) + chunk("IDAT", "none") + chunk("IEND", ""));
  const auto opened = open();
  ASSERT_TRUE(opened);
  ASSERT_TRUE((*opened)->next());
  EXPECT_THAT((*opened)->next().error().message,
              AllOf(HasSubstr("1.png"), HasSubstr("the image is 900x700, the camera of")));
  EXPECT_THAT((*opened)->picture(1).error().message, HasSubstr("the image is 900x700"));
  EXPECT_TRUE((*opened)->next());
}

}  // namespace
}  // namespace covis::io
