// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/colmap_model.h"

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
  std::filesystem::remove(folder / "cameras.txt");
  write_file(folder / "cameras.bin", "");
  EXPECT_THAT(read_colmap(folder.path()).error().message, HasSubstr("model_converter"));
}

}  // namespace
}  // namespace covis::exchange
