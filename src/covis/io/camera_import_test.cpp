// SPDX-License-Identifier: Apache-2.0
#include "covis/io/camera_import.h"

#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class CameraImport : public RecordingTest {
 protected:
  ImportedCamera imported(const std::string& name, const std::string& text) const {
    write(name, text);
    auto found = import_camera_yaml(folder / name);
    EXPECT_TRUE(found && *found) << (found ? "not recognised" : found.error().message);
    if (!found || !*found) return {};
    // Whatever is imported is read again as it is.
    write("again.yaml", camera_text((**found).file));
    const auto again = load_camera(folder / "again.yaml");
    EXPECT_TRUE(again) << again.error().message;
    if (again) {
      EXPECT_EQ(difference((**found).file.camera, again->camera), "");
    }
    return **found;
  }
  std::string import_error(const std::string& name, const std::string& text) const {
    write(name, text);
    const auto found = import_camera_yaml(folder / name);
    EXPECT_FALSE(found);
    return found ? "" : found.error().message;
  }
};

constexpr const char* kKalibrLeft =
    "cam0:\n  cam_overlaps: [1]\n  camera_model: pinhole\n  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.7e-05]\n"
    "  distortion_model: radtan\n  intrinsics: [458, 457, 367, 248]\n  resolution: [752, 480]\n"
    "  rostopic: /cam0/image_raw\n";
constexpr const char* kKalibrRight =
    "cam1:\n  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.11]\n  - [0.0, 1.0, 0.0, 0.0004]\n  - [0.0, 0.0, 1.0, -0.0008]\n"
    "  - [0.0, 0.0, 0.0, 1.0]\n  camera_model: pinhole\n  distortion_coeffs: [-0.28, 0.07, -0.0001, -3e-05]\n"
    "  distortion_model: radtan\n  intrinsics: [457, 456, 379, 255]\n  resolution: [752, 480]\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST_F(CameraImport, OfKalibr) {
  const ImportedCamera mono = imported("camchain.yaml", kKalibrLeft);
  EXPECT_THAT(mono.format, HasSubstr("Kalibr"));
  EXPECT_EQ(mono.file.camera.width, 752);
  EXPECT_EQ(mono.file.camera.pinhole.fy, 457);
  EXPECT_EQ(mono.file.camera.distortion, Distortion::brown_conrady);
  EXPECT_EQ(mono.file.camera.coefficients, (std::array<double, 5>{-0.28, 0.07, 0.0002, 1.7e-05, 0}));
  EXPECT_FALSE(mono.pair);
  const ImportedCamera fisheye = imported("camchain.yaml", replaced(kKalibrLeft, "radtan", "equidistant"));
  EXPECT_EQ(fisheye.file.camera.distortion, Distortion::kannala_brandt);
}

TEST_F(CameraImport, OfAPairOfKalibrMakesTheFilesOfAEurocSequence) {
  const ImportedCamera stereo = imported("camchain.yaml", std::string(kKalibrLeft) + kKalibrRight + "cam2: {}\n");
  EXPECT_EQ(stereo.file.baseline, 0) << "the images are not rectified";
  EXPECT_THAT(stereo.notes, ElementsAre(HasSubstr("cam2")));
  ASSERT_TRUE(stereo.pair);
  for (const auto& [name, sensor] : {std::pair("left.yaml", &stereo.pair->left), {"right.yaml", &stereo.pair->right}}) {
    write(name, sensor_file_text(*sensor));
    const auto read = read_sensor_file(folder / name);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(difference(read->camera, sensor->camera), "");
    EXPECT_TRUE(read->T_bs.t().isApprox(sensor->T_bs.t(), 1e-12));
  }
  EXPECT_TRUE(stereo.pair->right.T_bs.t().isApprox(Eigen::Vector3d(0.11, -0.0004, 0.0008), 1e-12));
  // Read as a EuRoC sequence, the pair has its baseline.
  for (const int cam : {0, 1}) {
    const fs::path base = "mav0/cam" + std::to_string(cam);
    write(base / "sensor.yaml", sensor_file_text(cam == 0 ? stereo.pair->left : stereo.pair->right));
    image(base / "data/1403715273262142976.png", 50, 752, 480);
  }
  const auto opened = open();
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_NEAR((*opened)->camera().pinhole.baseline(), std::hypot(0.11, 0.0004, 0.0008), 1e-9);
}

TEST_F(CameraImport, OfARectifiedPairHasABaseline) {
  std::string left = replaced(kKalibrLeft, "radtan", "none"), right = left;
  right = "cam1:\n  T_cn_cnm1: [[1, 0, 0, -0.12], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n" +
          right.substr(right.find('\n') + 1);
  const ImportedCamera stereo = imported("c.yaml", left + right);
  EXPECT_NEAR(stereo.file.baseline, 0.12, 1e-12);
  EXPECT_FALSE(stereo.pair);
  EXPECT_THAT(import_error("c.yaml", left + replaced(right, "-0.12", "-120")),
              AllOf(HasSubstr("c.yaml: the baseline in metres: 120"), HasSubstr("to 100")));
  const ImportedCamera exchanged = imported("c.yaml", left + replaced(right, "-0.12", "0.12"));
  EXPECT_FALSE(exchanged.pair);
  EXPECT_EQ(exchanged.file.baseline, 0);
  EXPECT_THAT(exchanged.notes,
              ElementsAre(AllOf(HasSubstr("cam1 is left out"), HasSubstr("to the right of the left"))));
}

TEST_F(CameraImport, OfKalibrNamesTheFieldThatIsWrong) {
  const std::string left = kKalibrLeft;
  EXPECT_THAT(import_error("c.yaml", replaced(left, "pinhole", "omni")),
              AllOf(HasSubstr("c.yaml: cam0: camera_model 'omni'"), HasSubstr("must be pinhole")));
  EXPECT_THAT(import_error("c.yaml", replaced(left, "radtan", "fov")), HasSubstr("distortion_model 'fov'"));
  EXPECT_THAT(import_error("c.yaml", replaced(left, "458", "nan")), AllOf(HasSubstr("c.yaml:6"), HasSubstr("'nan'")));
  EXPECT_THAT(import_error("c.yaml", replaced(left, "[752, 480]", "[752]")),
              HasSubstr("resolution needs 2 numbers (cam0)"));
  EXPECT_THAT(import_error("c.yaml", replaced(left, "[458", "[0.7, 458")),
              AllOf(HasSubstr("c.yaml:6: intrinsics has 5 numbers"), HasSubstr("(cam0)")));
  EXPECT_THAT(import_error("c.yaml", replaced(left, "1.7e-05]", "1.7e-05, 0, 0.3]")),
              AllOf(HasSubstr("c.yaml:4: distortion_coeffs has 6 numbers"), HasSubstr("(cam0)")));
  EXPECT_THAT(import_error("c.yaml", replaced(left, "367", "3670")), HasSubstr("principal point"));
  EXPECT_THAT(import_error("c.yaml", replaced(left, "458", "-458")),
              AllOf(HasSubstr("c.yaml: fx, the focal length"), HasSubstr("(cam0)")));
  EXPECT_THAT(import_error("c.yaml", left + replaced(kKalibrRight, "T_cn_cnm1", "T_cam_imu")),
              AllOf(HasSubstr("'T_cn_cnm1' is missing"), HasSubstr("cam1")));
  EXPECT_THAT(import_error("c.yaml", left + replaced(kKalibrRight, "[1.0", "[2.0")),
              HasSubstr("does not hold a rotation"));
  EXPECT_THAT(import_error("c.yaml", "cam0: 5\n"), HasSubstr("camera_model"));
}

constexpr const char* kKimera =
    "%YAML:1.0\n# General sensor definitions.\ncamera_id: left_cam\nrate_hz: 20\nresolution: [752, 480]\n"
    "camera_model: pinhole\nintrinsics: [458, 457, 367, 248] #fu, fv, cu, cv\ndistortion_model: radtan\n"
    "distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05]\nT_BS:\n  cols: 4\n  rows: 4\n  data: [0, -1, 0, -0.02, "
    "1, 0, 0, 0, 0, 0, 1, 0.01, 0, 0, 0, 1]\n";

TEST_F(CameraImport, OfKimera) {
  const ImportedCamera mono = imported("LeftCameraParams.yaml", kKimera);
  EXPECT_EQ(mono.file.camera.pinhole.cx, 367);
  EXPECT_EQ(mono.file.fps, 20);
  EXPECT_EQ(mono.file.camera.distortion, Distortion::brown_conrady);
  EXPECT_FALSE(mono.pair);
  // The camera's x axis is the body's y axis.
  write("RightCameraParams.yaml", replaced(kKimera, "1, 0, 0, 0,", "1, 0, 0, 0.11,"));
  const ImportedCamera stereo = imported("LeftCameraParams.yaml", kKimera);
  ASSERT_TRUE(stereo.pair);
  EXPECT_TRUE(stereo.pair->right.T_bs.t().isApprox(Eigen::Vector3d(0.11, 0, 0), 1e-9));
  EXPECT_THAT(import_error("LeftCameraParams.yaml", replaced(kKimera, "radtan", "omni")),
              AllOf(HasSubstr("LeftCameraParams.yaml"), HasSubstr("distortion_model 'omni'")));
  EXPECT_THAT(import_error("LeftCameraParams.yaml", replaced(kKimera, "resolution", "size")),
              AllOf(HasSubstr("LeftCameraParams.yaml"), HasSubstr("'resolution' is missing")));
  EXPECT_THAT(import_error("LeftCameraParams.yaml", replaced(kKimera, "0.01", "nan")), HasSubstr("T_BS: 'nan'"));
}

constexpr const char* kRos =
    "image_width: 640\nimage_height: 480\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [500, 0, 320, 0, 501, 240, 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n"
    "  cols: 5\n  data: [0.1, -0.2, 0.001, 0.002, 0]\nprojection_matrix:\n  rows: 3\n  cols: 4\n"
    "  data: [490, 0, 321, 0, 0, 491, 241, 0, 0, 0, 1, 0]\n";

TEST_F(CameraImport, OfRos) {
  const ImportedCamera camera = imported("ost.yaml", kRos);
  EXPECT_EQ(camera.file.camera.pinhole.fy, 501);
  EXPECT_EQ(camera.file.camera.coefficients[3], 0.002);
  EXPECT_THAT(camera.notes, ElementsAre(HasSubstr("rectified images")));
  const ImportedCamera message = imported("echo.yaml",
                                          "height: 480\nwidth: 640\ndistortion_model: plumb_bob\nD: [0, 0, 0, 0, 0]\n"
                                          "K: [500, 0, 320, 0, 501, 240, 0, 0, 1]\n");
  EXPECT_EQ(message.file.camera.distortion, Distortion::none);
  EXPECT_THAT(message.notes, IsEmpty());
  const ImportedCamera opencv = imported(
      "out_camera_data.yml",
      "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n"
      "   dt: d\n   data: [ 500., 0., 320., 0., 501., 240., 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n"
      "   rows: 5\n   cols: 1\n   dt: d\n   data: [ 0.1, -0.2, 0., 0., 0.3 ]\n");
  EXPECT_EQ(opencv.file.camera.coefficients[4], 0.3);
  const std::string of_fisheye =
      "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\nfisheye_model: 1\ncamera_matrix: !!opencv-matrix\n"
      "   rows: 3\n   cols: 3\n   dt: d\n   data: [ 300., 0., 320., 0., 301., 240., 0., 0., 1. ]\n"
      "distortion_coefficients: !!opencv-matrix\n   rows: 4\n   cols: 1\n   dt: d\n"
      "   data: [ -0.012, 0.03, -0.025, 0.006 ]\n";
  const ImportedCamera fisheye = imported("out_camera_data.yml", of_fisheye);
  EXPECT_EQ(fisheye.file.camera.distortion, Distortion::kannala_brandt);
  EXPECT_EQ(fisheye.file.camera.coefficients[1], 0.03);
  EXPECT_EQ(imported("out_camera_data.yml", replaced(of_fisheye, "fisheye_model: 1", "fisheye_model: 0"))
                .file.camera.distortion,
            Distortion::brown_conrady);
  EXPECT_EQ(imported("out_camera_data.yml", replaced(of_fisheye, "-0.012, 0.03, -0.025, 0.006", "0, 0, 0, 0"))
                .file.camera.distortion,
            Distortion::kannala_brandt);
  EXPECT_THAT(import_error("ost.yaml", replaced(kRos, "plumb_bob", "thin_prism")),
              AllOf(HasSubstr("ost.yaml: distortion_model 'thin_prism'")));
  EXPECT_THAT(import_error("ost.yaml", replaced(kRos, "[500", "[0")),
              AllOf(HasSubstr("ost.yaml: K"), HasSubstr("positive")));
  EXPECT_THAT(import_error("ost.yaml", replaced(kRos, "640", "wide")),
              AllOf(HasSubstr("image_width"), HasSubstr("'wide'")));
  EXPECT_THAT(import_error("ost.yaml", replaced(kRos, "image_height", "rows")), HasSubstr("'image_height' is missing"));
}

TEST_F(CameraImport, OfOpen3dAndOfWhatIsNone) {
  const ImportedCamera camera =
      imported("camera_intrinsic.json",
               "{\"width\": 64, \"height\": 48, \"intrinsic_matrix\": [50, 0, 0, 0, 51, 0, 32, 24, 1]}");
  EXPECT_EQ(camera.file.camera.pinhole.fy, 51);
  EXPECT_THAT(import_error("c.yaml", "width: 64\nheight: 48\nfx: 50\nfy: 50\ncx: 32\ncy: 24\n"), HasSubstr("already"));
  EXPECT_THAT(import_error("c.yaml", "a: [1\n"), HasSubstr("not YAML"));
  for (const auto& [name, text] : {std::pair("c.yaml", "a: 1\n"), {"c.yaml", "hello\n"}, {"c.xml", "<a>: [\n"}}) {
    write(name, text);
    const auto found = import_camera_yaml(folder / name);
    EXPECT_TRUE(found && !*found) << text;
  }
}

}  // namespace
}  // namespace covis::io
