// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/colmap_model.h"

#include <limits>

#include "covis/exchange/colmap.h"
#include "covis/exchange/test_scene.h"

namespace covis::exchange {
namespace {

using testing::HasSubstr;

TEST(ColmapModel, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  Scene scene = ring_scenes()[0];
  keep_tracks(scene);
  ASSERT_TRUE(write_colmap(folder.path(), scene));
  const auto model = read_colmap(folder.path());
  ASSERT_TRUE(model) << model.error().message;
  EXPECT_EQ(model->camera.pinhole.fx, scene.cameras[0].pinhole.fx);
  EXPECT_EQ(model->camera.pinhole.cy, scene.cameras[0].pinhole.cy);
  EXPECT_EQ(model->camera.width, 640);
  ASSERT_EQ(model->images.size(), scene.views.size());
  for (size_t i = 0; i < scene.views.size(); ++i) {
    EXPECT_EQ(model->images[i].name, scene.views[i].image);
    EXPECT_TRUE(model->images[i].T_cw.R().isApprox(scene.views[i].T_cw.R(), 1e-12));
    EXPECT_EQ(model->images[i].T_cw.t(), scene.views[i].T_cw.t());
    EXPECT_FALSE(model->images[i].points.empty());
  }
}

class ColmapModelFiles : public testing::Test {
 protected:
  // The error of a model of these files, or "".
  std::string error(const std::string& cameras, const std::string& list) const {
    write_file(folder / "cameras.txt", cameras);
    write_file(folder / "images.txt", list);
    const auto model = read_colmap(folder.path());
    return model ? std::string() : model.error().message;
  }
  const TemporaryFolder folder;
  const std::string images = "1 1 0 0 0 0 0 0 1 a.png\n10 10 7\n2 1 0 0 0 1 0 0 1 b/with space.png\n\n";
};

TEST_F(ColmapModelFiles, HaveTheLensOfTheirCameraModel) {
  const auto camera = [&](const std::string& line) {
    EXPECT_EQ(error(line, images), "");
    return read_colmap(folder.path())->camera;
  };
  const Camera radial = camera("1 RADIAL 640 480 500 320 240 0.1 -0.02");
  EXPECT_EQ(radial.distortion, Distortion::brown_conrady);
  EXPECT_EQ(radial.pinhole.fy, 500);
  EXPECT_EQ(radial.pinhole.cx, 319.5);
  EXPECT_EQ(radial.coefficients, (std::array<double, 5>{0.1, -0.02, 0, 0, 0}));
  const Camera opencv = camera("1 OPENCV 640 480 500 501 320 240 0.1 -0.02 0.003 0.004");
  EXPECT_EQ(opencv.pinhole.fy, 501);
  EXPECT_EQ(opencv.coefficients, (std::array<double, 5>{0.1, -0.02, 0.003, 0.004, 0}));
  EXPECT_EQ(camera("1 OPENCV_FISHEYE 640 480 300 300 320 240 0 0 0 0").distortion, Distortion::kannala_brandt);
  EXPECT_EQ(camera("# a comment\n1 SIMPLE_PINHOLE 640 480 500 320 240").distortion, Distortion::none);
  EXPECT_EQ(read_colmap(folder.path())->images[1].name, "b/with space.png");
}

TEST_F(ColmapModelFiles, MayHaveLinesOfWindows) {
  EXPECT_EQ(error("1 PINHOLE 640 480 500 500 320 240\r\n",
                  "1 1 0 0 0 0 0 0 1 a.png\r\n10 10 7\r\n2 1 0 0 0 1 0 0 1 b.png\r\n\r\n"),
            "");
  EXPECT_EQ(read_colmap(folder.path())->images[0].name, "a.png");
  EXPECT_EQ(error("1 PINHOLE 640 480 500 500 320 240\n\n \r\n", images), "") << "an empty line is no second camera";
}

TEST_F(ColmapModelFiles, MayBeginWithAByteOrderMark) {
  const std::string camera = "1 PINHOLE 640 480 500 500 320 240";
  EXPECT_EQ(error("\xef\xbb\xbf" + camera, "\xef\xbb\xbf" + images), "");
  EXPECT_THAT(error("\xff\xfe" + camera, images), HasSubstr("cameras.txt: it is in UTF-16"));
  EXPECT_THAT(error(camera, "\xfe\xff" + images), HasSubstr("images.txt: it is in UTF-16"));
}

TEST_F(ColmapModelFiles, ThatAreWrongAreNamedWithTheirLine) {
  const std::string camera = "1 PINHOLE 640 480 500 500 320 240\n";
  EXPECT_THAT(error("", images), HasSubstr("cameras.txt:0: there is no camera"));
  EXPECT_THAT(error("1 FOV 640 480 1 2 3 4 5\n", images), HasSubstr("camera model 'FOV'"));
  EXPECT_THAT(error("1 PINHOLE 0x280 480 500 500 320 240\n", images), HasSubstr("decimal numbers"));
  EXPECT_THAT(error("1 PINHOLE 640 480 500 500 320\n", images), HasSubstr("cameras.txt:1: "));
  EXPECT_THAT(error("1 PINHOLE 640 480 nan 500 320 240\n", images), HasSubstr("positive focal lengths"));
  EXPECT_THAT(error(camera + "2 PINHOLE 640 480 500 500 320 240\n", images), HasSubstr("second camera"));
  EXPECT_THAT(error(camera, "1 1 0 0 0 0 0 0 1 a.png\n"), HasSubstr("images.txt:1: the line with the points"));
  EXPECT_THAT(error(camera, "1 2 0 0 0 0 0 0 1 a.png\n\n"), HasSubstr("unit quaternion"));
  EXPECT_THAT(error(camera, "1 1 0 0 0 0 0 0 3 a.png\n\n"), HasSubstr("of a camera that cameras.txt does not have"));
  EXPECT_THAT(error(camera, "1 1 0 0 0 0 0 0 1 a.png\n10 10 x\n"), HasSubstr("images.txt:2: x, y and the point's id"));
  EXPECT_THAT(error(camera, "1 1 0 0 0 0 0 0 1 a.png\n10 10\n"), HasSubstr("images.txt:2: x, y and the point's id"));
  EXPECT_THAT(error(camera, "1 1 0 0 0 0 0 0 1 a.png\n1 1 99999999999999999999\n"), HasSubstr("images.txt:2: "));
  EXPECT_THAT(error(camera, "1 1 0 0 0 0 0 0 1 ../a.png\n\n"), HasSubstr("outside the folder"));
  EXPECT_THAT(error(camera, "1 1 0 0 0 1e300 0 0 1 a.png\n\n"), HasSubstr("translation"));
  EXPECT_THAT(error(camera, images + images), HasSubstr("another image of the id 1"));
  EXPECT_THAT(error("1 PINHOLE 640 480 500 500 320 240 7\n", images), HasSubstr("cameras.txt:1: "));
  EXPECT_THAT(error("1 PINHOLE 640 480 1e-300 500 320 240\n", images), HasSubstr("focal lengths of a pixel or more"));
  EXPECT_THAT(error("1 PINHOLE 2000000000 480 500 500 320 240\n", images), HasSubstr("at most 32768 x 32768"));
  EXPECT_THAT(error("1 OPENCV 640 480 500 500 320 240 1e300 0 0 0\n", images), HasSubstr("cameras.txt:1: "));
  EXPECT_THAT(error(camera, "1 1 0 0 0 0 0 0 1 a.png\n\n"), HasSubstr("less than two images"));
}

// Bytes as COLMAP writes numbers.
template <class... Numbers>
std::string bytes_of(const Numbers&... numbers) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&numbers), sizeof numbers), ...);
  return bytes;
}

class BinaryColmapModel : public testing::Test {
 protected:
  std::string error(const std::string& cameras, const std::string& list) const {
    write_file(folder / "cameras.bin", cameras);
    write_file(folder / "images.bin", list);
    const auto model = read_colmap(folder.path());
    return model ? std::string() : model.error().message;
  }
  static std::string pinhole(uint64_t width = 640, int32_t model = 1) {
    return bytes_of(uint32_t{5}, model, width, uint64_t{480}, 500., 501., 320., 240.);
  }
  // It shows the points 9 and 7, and between them none.
  static std::string image(uint32_t id, const std::string& name, double w = 1, uint32_t camera = 5) {
    return bytes_of(id, w, 0., 0., 0., 1., 2., 3., camera) + name + '\0' +
           bytes_of(uint64_t{3}, 10., 10., uint64_t{9}, 11., 11., ~uint64_t{0}, 12., 12., uint64_t{7});
  }
  const TemporaryFolder folder;
  const std::string one = bytes_of(uint64_t{1}), two = bytes_of(uint64_t{2});
  const std::string camera = one + pinhole(), images = two + image(8, "b/c d.png") + image(3, "a.png");
};

TEST_F(BinaryColmapModel, IsReadAsATextIs) {
  ASSERT_EQ(error(camera, images), "");
  const ColmapModel model = *read_colmap(folder.path());
  EXPECT_EQ(model.camera.pinhole.fy, 501);
  EXPECT_EQ(model.camera.pinhole.cx, 319.5);
  EXPECT_EQ(model.camera.width, 640);
  ASSERT_EQ(model.images.size(), 2u);
  EXPECT_EQ(model.images[0].name, "a.png") << "by rising id";
  EXPECT_EQ(model.images[1].name, "b/c d.png");
  EXPECT_EQ(model.images[1].T_cw.t(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(model.images[0].points, (std::vector<int64_t>{7, 9}));
  EXPECT_EQ(read_colmap_camera(folder / "cameras.bin")->height, 480);
  const std::string lens =
      bytes_of(uint32_t{5}, int32_t{3}, uint64_t{640}, uint64_t{480}, 500., 320., 240., 0.1, -0.02);
  ASSERT_EQ(error(one + lens, images), "");
  EXPECT_EQ(read_colmap_camera(folder / "cameras.bin")->coefficients, (std::array<double, 5>{0.1, -0.02, 0, 0, 0}));
}

TEST_F(BinaryColmapModel, ThatIsWrongIsNamed) {
  EXPECT_THAT(error(two + pinhole() + pinhole(), images), HasSubstr("cameras.bin: there are 2 cameras; one is wanted"));
  EXPECT_THAT(error(bytes_of(uint64_t{0}), images), HasSubstr("there is no camera"));
  EXPECT_THAT(error(one + pinhole(640, 7), images), HasSubstr("camera model 'FOV' is none of"));
  EXPECT_THAT(error(one + pinhole(640, -1), images), HasSubstr("camera model '-1' is none of"));
  EXPECT_THAT(error(one + pinhole(uint64_t{1} << 63), images), HasSubstr("at most 32768 x 32768"));
  EXPECT_THAT(error(camera + "x", images), HasSubstr("bytes behind the camera"));
  EXPECT_THAT(error(camera, images + "x"), HasSubstr("images.bin: there are bytes behind the last image"));
  EXPECT_THAT(error(camera, two + image(8, "a", 2) + image(3, "b")), HasSubstr("image 1 of 2: an image's id, unit"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string lost =
      bytes_of(uint32_t{8}, 1., 0., 0., 0., 1., 2., nan, uint32_t{5}) + "a" + '\0' + bytes_of(uint64_t{0});
  EXPECT_THAT(error(camera, two + lost + image(3, "b")), HasSubstr("image 1 of 2: an image's id, unit quaternion"));
  EXPECT_THAT(error(camera, two + image(8, "a", nan) + image(3, "b")), HasSubstr("image 1 of 2: an image's id, unit"));
  EXPECT_THAT(error(camera, two + image(8, "a") + image(3, "b", 1, 4)), HasSubstr("image 2 of 2: the image is of a"));
  EXPECT_THAT(error(camera, two + image(8, "a") + image(8, "b")), HasSubstr("another image of the id 8"));
  EXPECT_THAT(error(camera, two + image(8, "a") + image(3, "../b")), HasSubstr("outside the folder"));
  EXPECT_THAT(error(camera, one + image(8, "a")), HasSubstr("images.bin: there are less than two images"));
  EXPECT_THAT(error("", images), HasSubstr("cameras.bin: at the number of cameras, 0 bytes are fewer"));
  std::filesystem::remove(folder / "images.bin");
  EXPECT_THAT(read_colmap(folder.path()).error().message, HasSubstr("images.bin: there is no such file"));
}

// Counts are held against the size of the file before anything is made of them.
TEST_F(BinaryColmapModel, WhoseCountsAreMoreThanItsBytesIsRefused) {
  EXPECT_THAT(error(camera, bytes_of(~uint64_t{0}) + image(8, "a")), HasSubstr("at the number of images, "));
  const std::string points = bytes_of(uint32_t{8}, 1., 0., 0., 0., 1., 2., 3., uint32_t{5}) + "a" + '\0';
  EXPECT_THAT(error(camera, two + points + bytes_of(~uint64_t{0} / 24) + image(3, "b")),
              HasSubstr("at the points of image 1 of 2, "));
  EXPECT_THAT(error(camera, two + image(8, std::string(5000, 'n')) + image(3, "b")), HasSubstr("at image 1 of 2, "));
  for (const std::string* whole : {&camera, &images}) {
    for (size_t size = 0; size < whole->size(); ++size) {
      const std::string part = whole->substr(0, size);
      EXPECT_NE(whole == &camera ? error(part, images) : error(camera, part), "") << size;
    }
  }
}

}  // namespace
}  // namespace covis::exchange
