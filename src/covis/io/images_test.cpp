// SPDX-License-Identifier: Apache-2.0
#include "covis/io/images.h"

#include <sys/stat.h>

#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "covis/core/random.h"
#include "covis/io/files.h"
#include "covis/io/image_bytes.h"
#include "covis/io/opencv_picture.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Images : public RecordingTest {
 protected:
  // An image that does not compress away.
  cv::Mat noise(int type = CV_8UC3) const {
    Random random(7);
    cv::Mat image(kHeight, kWidth, type);
    for (int y = 0; y < image.rows; ++y) {
      for (size_t x = 0; x < static_cast<size_t>(image.cols) * image.elemSize(); ++x)
        image.ptr(y)[x] = static_cast<uint8_t>(random.below(256));
    }
    return image;
  }
  std::string saved(const std::string& name, const cv::Mat& image) const {
    cv::imwrite((folder / name).string(), image);
    return *read_text(folder / name);
  }

  ImageReader reader;
  ImageU8 grey;
  ImageF metres;
};

TEST_F(Images, PicturesKeepTheirColours) {
  saved("colour.png", cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar(10, 20, 30)));  // blue first
  saved("grey.png", cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(40)));
  const auto colour = read_picture(folder / "colour.png"), plain = read_picture(folder / "grey.png");
  ASSERT_TRUE(colour && plain);
  EXPECT_EQ(std::vector<uint8_t>(colour->row(5), colour->row(5) + 4), (std::vector<uint8_t>{30, 20, 10, 30}));
  EXPECT_FALSE(plain->coloured());
  EXPECT_EQ(plain->row(5)[3], 40);
  EXPECT_EQ(colour->file, folder / "colour.png");
  EXPECT_TRUE(may_have_colours(folder / "colour.png"));
  EXPECT_FALSE(may_have_colours(folder / "grey.png"));
  for (const char* name : {"again.png", "again.jpg"}) {
    ASSERT_TRUE(write_picture(folder / name, *colour));
    EXPECT_NEAR(read_picture(folder / name)->row(9)[2], 10, 2) << name;
  }
}

// Pictures are turned as the images that are tracked are, and what is turned is not what the file holds.
TEST_F(Images, AnOrientationInTheFileIsFollowed) {
  const std::string jpeg = saved("upright.jpg", noise());
  const auto tiff = [](char orientation) {
    const std::string entry("\x12\x01\x03\x00\x01\x00\x00\x00", 8), value{orientation, 0, 0, 0};
    return std::string("II*\0\x08\0\0\0\x01\0", 10) + entry + value + std::string(4, '\0');
  };
  const auto with_orientation = [&](char orientation) {
    const std::string exif = std::string("Exif\0\0", 6) + tiff(orientation);
    const auto length = static_cast<char>(exif.size() + 2);
    return jpeg.substr(0, 2) + std::string("\xff\xe1\0", 3) + length + exif + jpeg.substr(2);
  };
  write("turned.jpg", with_orientation(6));
  write("same.jpg", with_orientation(1));
  const auto turned = read_picture(folder / "turned.jpg"), same = read_picture(folder / "same.jpg");
  ASSERT_TRUE(turned && same);
  EXPECT_EQ(turned->width, kHeight);
  EXPECT_TRUE(turned->file.empty());
  EXPECT_EQ(same->width, kWidth);
  EXPECT_EQ(same->file, folder / "same.jpg");
  ASSERT_TRUE(reader.grey(folder / "turned.jpg", grey));
  EXPECT_EQ(grey.width(), kHeight);
  reader.leave_unturned();
  ASSERT_TRUE(reader.grey(folder / "turned.jpg", grey));
  EXPECT_EQ(grey.width(), kWidth);
  // The chunk of a PNG with its checksum, behind the pixels (Extensions to the PNG specification, section 4.7).
  const std::string png = saved("upright.png", noise()), chunk("\0\0\0\x1a\x65XIf", 8), crc = "\xb7\x48\x11\x29";
  write("turned.png", png.substr(0, png.size() - 12) + chunk + tiff(6) + crc + png.substr(png.size() - 12));
  const auto turned_png = read_picture(folder / "turned.png");
  ASSERT_TRUE(turned_png) << turned_png.error().message;
  EXPECT_EQ(turned_png->file.empty(), turned_png->width == kHeight) << "which depends on OpenCV's version";
}

TEST_F(Images, GreyIsWhatOpenCvMakesOfColour) {
  const cv::Mat colour = noise();
  cv::Mat wanted;
  cv::cvtColor(colour, wanted, cv::COLOR_BGR2GRAY);
  for (const char* name : {"a.png", "a.bmp", "a.tiff", "a.ppm"}) {
    saved(name, colour);
    ASSERT_TRUE(reader.grey(folder / name, grey)) << name;
    ASSERT_EQ(grey.width(), kWidth);
    ASSERT_EQ(grey.height(), kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) ASSERT_NEAR(grey(x, y), wanted.at<uint8_t>(y, x), 1) << name;
    }
  }
}

TEST_F(Images, FramesOfAnyNumberOfChannelsBecomeGrey) {
  const cv::Mat colour = noise();
  cv::Mat wanted, with_alpha;
  cv::cvtColor(colour, wanted, cv::COLOR_BGR2GRAY);
  cv::cvtColor(colour, with_alpha, cv::COLOR_BGR2BGRA);
  for (const cv::Mat& frame : {colour, wanted, with_alpha}) {
    to_grey(frame, grey);
    EXPECT_EQ(cv::norm(as_mat(grey, CV_8UC1), wanted, cv::NORM_INF), 0) << frame.channels();
  }
}

TEST_F(Images, MemoryIsUsedAgain) {
  saved("a.png", noise());
  saved("b.jpg", noise());
  ASSERT_TRUE(reader.grey(folder / "a.png", grey));
  const uint8_t* memory = grey.row(0);
  ASSERT_TRUE(reader.grey(folder / "b.jpg", grey));
  EXPECT_EQ(grey.row(0), memory);
  depth("d.png", 2000);
  ASSERT_TRUE(reader.depth(folder / "d.png", 1000, metres));
  const float* depth_memory = metres.row(0);
  depth("d.png", 3000);
  ASSERT_TRUE(reader.depth(folder / "d.png", 1000, metres));
  EXPECT_EQ(metres.row(0), depth_memory);
  EXPECT_FLOAT_EQ(metres(3, 3), 3);
}

TEST_F(Images, DepthOfEveryKind) {
  cv::Mat d16(kHeight, kWidth, CV_16U, cv::Scalar(2500));
  d16.at<uint16_t>(0, 1) = 0;
  d16.at<uint16_t>(0, 2) = 65535;
  d16.at<uint16_t>(0, 3) = 65534;
  saved("d.png", d16);
  ASSERT_TRUE(reader.depth(folder / "d.png", 5000, metres));
  EXPECT_FLOAT_EQ(metres(0, 0), 0.5f);
  EXPECT_EQ(metres(1, 0), 0);
  EXPECT_EQ(metres(2, 0), 0) << "none, or farther than the image can hold";
  EXPECT_FLOAT_EQ(metres(3, 0), 13.1068f);

  cv::Mat d32(kHeight, kWidth, CV_32F, cv::Scalar(1.25));
  d32.at<float>(0, 1) = std::numeric_limits<float>::quiet_NaN();
  d32.at<float>(0, 2) = -1;
  d32.at<float>(0, 3) = std::numeric_limits<float>::infinity();
  saved("d.tiff", d32);
  ASSERT_TRUE(reader.depth(folder / "d.tiff", 5000, metres));
  EXPECT_EQ(metres(0, 0), 1.25f) << "float is metres, whatever the scale";
  for (const int x : {1, 2, 3}) EXPECT_EQ(metres(x, 0), 0);
  ASSERT_TRUE(reader.depth(folder / "d.png", 5000, metres)) << "16 bits after float";
  EXPECT_FLOAT_EQ(metres(0, 0), 0.5f);

  saved("grey.png", noise(CV_8UC1));
  EXPECT_THAT(reader.depth(folder / "grey.png", 5000, metres).error().message,
              AllOf(HasSubstr("grey.png"), HasSubstr("16 bits")));
}

TEST_F(Images, AFileCutShortAnywhereIsTold) {
  for (const char* name : {"a.png", "a.jpg"}) {
    const std::string whole = saved(name, noise());
    ASSERT_TRUE(reader.grey(folder / name, grey));
    for (const size_t left : {whole.size() - 2, whole.size() / 2, size_t{100}, size_t{10}, size_t{3}}) {
      write(name, whole.substr(0, left));
      EXPECT_THAT(reader.grey(folder / name, grey).error().message, HasSubstr(name)) << left;
    }
  }
}

TEST_F(Images, ThePreviewInAJpegIsNotItsEnd) {
  const std::string whole = saved("a.jpg", noise()), preview = saved("b.jpg", cv::Mat(8, 8, CV_8U, cv::Scalar(0)));
  const size_t length = preview.size() + 2;
  const std::string header{'\xff', '\xe1', static_cast<char>(length / 256), static_cast<char>(length % 256)};
  const std::string with_preview = whole.substr(0, 2) + header + preview + whole.substr(2);
  write("a.jpg", with_preview);
  ASSERT_TRUE(reader.grey(folder / "a.jpg", grey));
  EXPECT_EQ(grey.width(), kWidth);
  write("a.jpg", with_preview.substr(0, with_preview.size() - whole.size() / 2));
  EXPECT_THAT(reader.grey(folder / "a.jpg", grey).error().message, HasSubstr("cut short"));
}

// A decoder that gives up at the header leaves the memory it was given as it was, with the image before.
TEST_F(Images, ABrokenHeaderIsToldAndNotTakenForTheImageBefore) {
  const auto is_told = [&](const std::string& name, const std::string& whole, size_t at, char wrong) {
    std::string bytes = whole;
    bytes[at] = wrong;
    write(name, bytes);
    const bool depths = name.starts_with("d");
    const Result<void> read = depths ? reader.depth(folder / name, 5000, metres) : reader.grey(folder / name, grey);
    EXPECT_FALSE(read) << name << " " << at;
  };
  const std::string png = saved("a.png", noise()), jpeg = saved("a.jpg", noise()), tiff = saved("a.tiff", noise()),
                    bmp = saved("a.bmp", noise()), depths = saved("d.png", noise(CV_16U));
  ASSERT_TRUE(reader.grey(folder / "a.png", grey));
  for (size_t at = 12; at < 33; ++at) is_told("a.png", png, at, static_cast<char>(png[at] ^ 0x40));
  const size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  ASSERT_TRUE(reader.grey(folder / "a.jpg", grey));
  for (const size_t behind : {1, 4, 9}) is_told("a.jpg", jpeg, frame + behind, '\x17');
  ASSERT_TRUE(reader.grey(folder / "a.tiff", grey));
  is_told("a.tiff", tiff, 2, 'x');
  is_told("a.bmp", bmp, 28, 'x');
  ASSERT_TRUE(reader.depth(folder / "d.png", 5000, metres));
  for (size_t at = 16; at < 29; ++at) is_told("d.png", depths, at, static_cast<char>(depths[at] ^ 0x40));
}

TEST_F(Images, ThePartOfAJpegThatIsDamagedIsTold) {
  const std::vector<std::vector<int>> kinds{{cv::IMWRITE_JPEG_QUALITY, 95},
                                            {cv::IMWRITE_JPEG_QUALITY, 40},
                                            {cv::IMWRITE_JPEG_OPTIMIZE, 1},
                                            {cv::IMWRITE_JPEG_RST_INTERVAL, 3}};
  int all = 0, noticed = 0;
  for (const cv::Size size : {cv::Size(64, 48), cv::Size(67, 41), cv::Size(16, 200)}) {
    for (const int type : {CV_8UC3, CV_8UC1}) {
      for (const std::vector<int>& kind : kinds) {
        cv::Mat image;
        cv::resize(noise(type), image, size);
        std::vector<uint8_t> encoded;
        ASSERT_TRUE(cv::imencode(".jpg", image, encoded, kind));
        const std::string whole(encoded.begin(), encoded.end());
        SCOPED_TRACE(testing::Message() << size << " " << type << " " << kind[0] << " " << kind[1]);
        EXPECT_FALSE(problem_of_image(whole));
        const size_t data = whole.find("\xff\xda") + 14, length = whole.size() - data;
        std::string zeroed = whole;
        zeroed.replace(data + length / 3, length / 3, length / 3, '\0');
        ++all;
        noticed += problem_of_image(zeroed).has_value();
        EXPECT_THAT(problem_of_image(whole.substr(0, data + length / 2) + "\xff\xd9").value_or(""),
                    HasSubstr("damaged or cut short"));
      }
    }
  }
  EXPECT_EQ(all, 24);
  EXPECT_GE(noticed, 22) << "zeros may be codes of as many blocks as were there, by chance";
  // Flat images have the shortest codes there are, in padded data.
  std::vector<uint8_t> flat;
  cv::imencode(".jpg", cv::Mat(480, 640, CV_8UC1, cv::Scalar(0)), flat, {cv::IMWRITE_JPEG_OPTIMIZE, 1});
  std::string padded(flat.begin(), flat.end());
  EXPECT_FALSE(problem_of_image(padded));
  padded.insert(padded.size() - 2, 16, '\0');
  EXPECT_FALSE(problem_of_image(padded));
  // Codes of a first coefficient of more than 16 bits, short and long ones.
  const std::string whole = saved("a.jpg", noise());
  std::string meaningless = whole;
  const size_t symbols = whole.find(std::string("\xff\xc4\0\x1f\0", 5)) + 21;
  ASSERT_GT(symbols, 21u);
  meaningless.replace(symbols, 12, 12, '\x21');
  EXPECT_THAT(problem_of_image(meaningless).value_or(""), HasSubstr("damaged"));
}

// A JPEG of one block, whose coefficients but the first have Huffman codes of these lengths. There is one code of each
// length, ones and a zero at the end: that of 1 ends the block, that of 16 has this symbol, others are for a
// coefficient of one bit.
std::string jpeg_of_codes(const std::vector<int>& lengths, char symbol_of_16 = 1) {
  std::string bits = "0";  // the first coefficient's
  for (const int length : lengths)
    bits += std::string(static_cast<size_t>(length) - 1, '1') + (length > 1 ? "01" : "0");
  bits.resize((bits.size() + 7) / 8 * 8, '1');
  std::string bytes = "\xff\xd8\xff\xdb" + std::string("\0\x43\0", 3) + std::string(64, '\1') +
                      std::string("\xff\xc0\0\x0b\x08\0\x08\0\x08\x01\x01\x11\0", 13) +
                      std::string("\xff\xc4\0\x14\0\1", 6) + std::string(16, '\0') +
                      std::string("\xff\xc4\0\x23\x10", 5) + std::string(16, '\1') + std::string(1, '\0') +
                      std::string(14, '\1') + symbol_of_16 + std::string("\xff\xda\0\x08\x01\x01\0\0\x3f\0", 10);
  for (size_t i = 0; i < bits.size(); i += 8) {
    bytes += static_cast<char>(std::stoi(bits.substr(i, 8), nullptr, 2));
    if (bytes.back() == '\xff') bytes += '\0';
  }
  return bytes + "\xff\xd9";
}

TEST_F(Images, LongCodesOfAJpegAreFollowed) {
  std::vector<int> lengths{9, 10, 11, 12, 13, 14, 15, 16, 1};
  for (const auto& codes : {lengths, std::vector<int>(63, 16)}) {
    const std::string whole = jpeg_of_codes(codes);
    EXPECT_EQ(problem_of_image(whole), std::nullopt);
    write("a.jpg", whole);
    EXPECT_TRUE(reader.grey(folder / "a.jpg", grey)) << "as the decoder reads it";
    std::string cut = whole;
    cut.erase(cut.size() - 6, 4);
    EXPECT_THAT(problem_of_image(cut).value_or(""), HasSubstr("damaged"));
  }
  lengths.insert(lengths.begin(), 17);
  EXPECT_THAT(problem_of_image(jpeg_of_codes(lengths)).value_or(""), HasSubstr("damaged")) << "16 ones are no code";
  std::vector<int> skipping{16, 16, 16};
  skipping.insert(skipping.end(), 15, 15);
  EXPECT_EQ(problem_of_image(jpeg_of_codes(skipping, '\xf1')), std::nullopt) << "three times 16 and 15 coefficients";
  EXPECT_THAT(problem_of_image(jpeg_of_codes({16, 16, 16, 16, 1}, '\xf1')).value_or(""), HasSubstr("damaged"))
      << "four times 16 coefficients and the first are more than a block";
}

TEST_F(Images, BytesThatAJpegMayHoldBetweenItsPartsAreNoDamage) {
  std::vector<uint8_t> encoded;
  ASSERT_TRUE(cv::imencode(".jpg", noise(), encoded, {cv::IMWRITE_JPEG_RST_INTERVAL, 3}));
  const std::string whole(encoded.begin(), encoded.end());
  std::string filled;
  int restarts = 0;
  for (size_t i = 0; i < whole.size(); ++i) {
    const bool restart =
        i > whole.find("\xff\xda") && whole[i] == '\xff' && (static_cast<unsigned char>(whole[i + 1]) & 0xf8) == 0xd0;
    if (restart) filled += std::string(1 + restarts++ % 3, '\xff');
    filled += whole[i];
  }
  EXPECT_GT(restarts, 1);
  EXPECT_EQ(problem_of_image(filled), std::nullopt) << "fill bytes before restarts";
  filled.insert(filled.size() - 2, 1000, '\xff');
  EXPECT_EQ(problem_of_image(filled), std::nullopt) << "fill bytes before the end";
  std::string stray = whole;
  stray.insert(whole.find("\xff\xc0"), std::string("\0\0ab\xff\0\xff", 7));
  EXPECT_EQ(problem_of_image(stray), std::nullopt) << "bytes between segments";
  for (const std::string& bytes : {filled, stray}) {
    write("a.jpg", bytes);
    const auto read = reader.grey(folder / "a.jpg", grey);
    EXPECT_TRUE(read) << "as the decoder reads them: " << read.error().message;
  }
}

TEST_F(Images, APictureInPlainTextMayEndWithItsLastNumber) {
  write("a.pgm", "P2\n3 2\n255\n1 2 3 4 5 60");
  ASSERT_TRUE(reader.grey(folder / "a.pgm", grey));
  EXPECT_EQ(grey(2, 1), 60);
}

TEST_F(Images, ATiffMayLackTheLengthsOfItsStrips) {
  std::string tiff = saved("a.tiff", noise());
  const size_t list = static_cast<unsigned char>(tiff[4]) | static_cast<unsigned char>(tiff[5]) << 8 |
                      static_cast<unsigned char>(tiff[6]) << 16;
  size_t lengths = list + 2;
  while (lengths < tiff.size() && tiff.substr(lengths, 2) != "\x17\x01") lengths += 12;
  ASSERT_LT(lengths, tiff.size());
  tiff.replace(lengths, 2, "\x19\x01");
  EXPECT_EQ(problem_of_image(tiff), std::nullopt);
}

// OpenCV would write to stderr about these, or make an empty image of them.
TEST_F(Images, WhatNoDecoderReadsIsToldBeforeIt) {
  const auto problem = [](std::string bytes) { return problem_of_image(bytes).value_or(""); };
  for (const char* name : {"a.pgm", "a.ppm", "a.pbm", "a.bmp"}) {
    const bool colour = std::string_view(name) == "a.ppm";
    const std::string whole = saved(name, cv::Mat(kHeight, kWidth, colour ? CV_8UC3 : CV_8UC1, cv::Scalar::all(200)));
    EXPECT_EQ(problem(whole), "") << name;
    for (const size_t left : {whole.size() - 1, whole.size() / 2, size_t{15}})
      EXPECT_THAT(problem(whole.substr(0, left)), HasSubstr("cut short")) << name << " " << left;
  }
  EXPECT_EQ(problem("P5 # a comment\n2 1\n255\nab"), "");
  EXPECT_EQ(problem("P2\n2 1\n255\n1 2\n"), "");
  EXPECT_THAT(problem("P5\nwide high\n255\n"), HasSubstr("has no size"));
  EXPECT_THAT(problem("P5\n-3 2\n255\n"), HasSubstr("has no size"));
  EXPECT_THAT(problem("P5"), HasSubstr("has no size"));
  EXPECT_THAT(problem("P5\n99999999999 1\n255\n"), HasSubstr("sides of 1 to"));
  EXPECT_THAT(problem("P5\n2 1\n0\nab"), HasSubstr("greatest value"));
  EXPECT_THAT(problem("P5\n2 1\n256\nabc"), HasSubstr("cut short"));
  std::string tiff = saved("a.tiff", noise());
  const size_t compression = tiff.find(std::string("\x03\x01\x03\x00\x01\x00\x00\x00", 8));
  ASSERT_NE(compression, std::string::npos);
  tiff[compression + 8] = 99;
  EXPECT_THAT(problem(tiff), HasSubstr("compression is 99"));
}

TEST_F(Images, ATiffWhosePixelsLieBehindItsEndIsTold) {
  std::string tiff = saved("a.tiff", noise());
  EXPECT_FALSE(problem_of_image(tiff));
  EXPECT_THAT(problem_of_image(tiff.substr(0, tiff.size() / 2)).value_or(""), HasSubstr("cut short"));
  tiff.replace(4, 4, std::string(4, '\xff'));
  EXPECT_THAT(problem_of_image(tiff).value_or(""), HasSubstr("cut short"));
}

TEST_F(Images, TheSizeIsReadBeforeMemoryIsAskedFor) {
  const std::string header("\0\0\0\x0dIHDR\0\0\xea\x60\0\0\xea\x60\x08\0\0\0\0\xa5\xb9\x2a\x9e", 25);
  std::string png = saved("a.png", noise());
  png.replace(8, 25, header);
  write("a.png", png);
  EXPECT_THAT(reader.grey(folder / "a.png", grey).error().message,
              AllOf(HasSubstr("a.png"), HasSubstr("60000x60000"), HasSubstr("20000")));
}

TEST_F(Images, AFileThatNeverEndsIsRefused) {
  ASSERT_EQ(mkfifo((folder / "a.png").c_str(), 0600), 0);
  EXPECT_THAT(reader.grey(folder / "a.png", grey).error().message, HasSubstr("a.png: it is a pipe or a device"));
  EXPECT_FALSE(may_have_colours(folder / "a.png"));
  fs::create_symlink("/dev/zero", folder / "b.png");
  EXPECT_THAT(reader.grey(folder / "b.png", grey).error().message, HasSubstr("b.png: it is a pipe or a device"));
  write("c.png", "");
  fs::resize_file(folder / "c.png", uintmax_t{1} << 40);  // takes no room on the disk
  EXPECT_THAT(reader.grey(folder / "c.png", grey).error().message, HasSubstr("c.png: it has more than 1024 MiB"));
}

TEST_F(Images, APngWithAWrongByteIsTold) {
  std::string bytes = saved("a.png", noise());
  bytes[bytes.size() / 2] ^= 0x55;
  write("a.png", bytes);
  EXPECT_THAT(reader.grey(folder / "a.png", grey).error().message, HasSubstr("a.png"));
}

}  // namespace
}  // namespace covis::io
