// SPDX-License-Identifier: Apache-2.0
#include "covis/io/bag_topics.h"

#include <gmock/gmock.h>

namespace covis::io {
namespace {

using testing::HasSubstr;

// Topics with a message each; names that end with a transport are of compressed images.
std::vector<BagTopic> topics_of(const std::vector<std::string>& names) {
  std::vector<BagTopic> topics;
  for (const std::string& name : names) {
    const bool compressed = name.find("/compressed") != std::string::npos;
    const char* type = name.ends_with("camera_info") ? "sensor_msgs/CameraInfo"
                       : compressed                  ? "sensor_msgs/CompressedImage"
                                                     : "sensor_msgs/Image";
    topics.push_back({name, type, {{}}});
  }
  return topics;
}

// "SENSOR image right depth", as far as they are chosen.
std::string chosen(const std::vector<std::string>& names, const TopicNames& wanted = {},
                   std::optional<Sensor> sensor = std::nullopt) {
  const std::vector<BagTopic> topics = topics_of(names);
  const auto found = choose_topics(topics, wanted, sensor);
  if (!found) return found.error().message;
  std::string text(name(found->sensor));
  for (const BagTopic* topic : {found->image, found->right, found->depth}) {
    if (topic) text += " " + topic->name;
  }
  return text;
}

const std::vector<std::string> kRealSense{"/camera/aligned_depth_to_color/image_raw",
                                          "/camera/aligned_depth_to_color/image_raw/compressedDepth",
                                          "/camera/color/camera_info",
                                          "/camera/color/image_raw",
                                          "/camera/color/image_raw/compressed",
                                          "/camera/depth/image_rect_raw",
                                          "/camera/infra1/image_rect_raw",
                                          "/camera/infra2/image_rect_raw"};

TEST(BagTopics, FoundByTheirNames) {
  EXPECT_EQ(chosen(kRealSense), "rgbd /camera/color/image_raw /camera/aligned_depth_to_color/image_raw");
  EXPECT_EQ(chosen(kRealSense, {}, Sensor::stereo),
            "stereo /camera/infra1/image_rect_raw /camera/infra2/image_rect_raw");
  EXPECT_EQ(chosen(kRealSense, {}, Sensor::monocular), "mono /camera/color/image_raw");
  EXPECT_EQ(chosen({"/camera/depth/image", "/camera/rgb/image_color"}),
            "rgbd /camera/rgb/image_color /camera/depth/image");
  EXPECT_EQ(chosen({"/camera/depth/image_rect_raw", "/camera/infra1/image_rect_raw", "/camera/infra2/image_rect_raw"}),
            "stereo /camera/infra1/image_rect_raw /camera/infra2/image_rect_raw")
      << "that depth is not registered to a colour image";
  EXPECT_EQ(chosen({"/cam0/image_raw", "/cam1/image_raw"}), "stereo /cam0/image_raw /cam1/image_raw");
  EXPECT_EQ(chosen({"/s/left/image_raw", "/s/left/image_rect", "/s/right/image_raw", "/s/right/image_rect"}),
            "stereo /s/left/image_rect /s/right/image_rect");
  EXPECT_EQ(chosen({"/rgb/image/compressed", "/depth_registered/image/compressedDepth"}),
            "rgbd /rgb/image/compressed /depth_registered/image/compressedDepth");
  EXPECT_EQ(chosen({"/usb_cam/image_raw", "/zoo/image"}), "mono /usb_cam/image_raw");
}

const std::vector<std::string> kRealSenseSdk{
    "/device_0/sensor_0/Depth_0/image/data", "/device_0/sensor_0/Depth_0/info/camera_info",
    "/device_0/sensor_1/Color_0/image/data", "/device_0/sensor_1/Color_0/info/camera_info"};

TEST(BagTopics, OfRealSensesSdkAreFoundInAnyCase) {
  EXPECT_EQ(chosen(kRealSenseSdk), "rgbd /device_0/sensor_1/Color_0/image/data /device_0/sensor_0/Depth_0/image/data");
  EXPECT_EQ(chosen(kRealSenseSdk, {}, Sensor::monocular), "mono /device_0/sensor_1/Color_0/image/data");
  EXPECT_EQ(chosen({"/device_0/sensor_0/Infrared_1/image/data", "/device_0/sensor_0/Infrared_2/image/data"}),
            "stereo /device_0/sensor_0/Infrared_1/image/data /device_0/sensor_0/Infrared_2/image/data");
  EXPECT_EQ(chosen({"/Left/image", "/Right/image"}), "stereo /Left/image /Right/image");
  const auto topics = topics_of(kRealSenseSdk);
  ASSERT_NE(camera_info_of(topics, topics[2]), nullptr);
  EXPECT_EQ(camera_info_of(topics, topics[2])->name, "/device_0/sensor_1/Color_0/info/camera_info");
  const auto beside = topics_of({"/a/image/data", "/a/image/camera_info"});
  ASSERT_NE(camera_info_of(beside, beside[0]), nullptr);
  EXPECT_EQ(camera_info_of(beside, beside[0])->name, "/a/image/camera_info") << "as of any other images";
}

TEST(BagTopics, DepthThatAzureKinectRegisteredToColourIsTaken) {
  EXPECT_EQ(chosen({"/depth/image_raw", "/depth_to_rgb/image_raw", "/ir/image_raw", "/rgb/image_raw",
                    "/rgb_to_depth/image_raw"}),
            "rgbd /rgb/image_raw /depth_to_rgb/image_raw");
  EXPECT_EQ(chosen({"/depth/image_raw", "/rgb/image_raw", "/z_depth_to_color/image_raw"}),
            "rgbd /rgb/image_raw /z_depth_to_color/image_raw");
  EXPECT_EQ(chosen({"/depth_to_rgb/image_raw", "/left/image_raw", "/rgb/image_raw", "/right/image_raw"}),
            "rgbd /rgb/image_raw /depth_to_rgb/image_raw")
      << "it is registered, and so comes before a pair";
}

TEST(BagTopics, NamedOnesAreTaken) {
  EXPECT_EQ(chosen(kRealSense, {.image = "/camera/infra2/image_rect_raw"}), "mono /camera/infra2/image_rect_raw");
  EXPECT_EQ(chosen(kRealSense, {.image = "/camera/infra1/image_rect_raw"}, Sensor::stereo),
            "stereo /camera/infra1/image_rect_raw /camera/infra2/image_rect_raw");
  EXPECT_EQ(chosen(kRealSense, {.depth = "/camera/depth/image_rect_raw"}),
            "rgbd /camera/color/image_raw /camera/depth/image_rect_raw");
}

TEST(BagTopics, SayWhatThereIs) {
  EXPECT_THAT(
      chosen({"/a/image", "/b/image"}, {.image = "/c/image"}),
      HasSubstr("topic /c/image: there is no image of it; the image topics are /a/image (sensor_msgs/Image, 1), "
                "/b/image"));
  EXPECT_THAT(chosen({"/a/image"}, {}, Sensor::rgbd), HasSubstr("name --depth-topic; the image topics are /a/image"));
  EXPECT_THAT(chosen({"/depth/image"}), HasSubstr("name --topic"));
  EXPECT_THAT(chosen({"/a/image"}, {.image = "/a/image"}, Sensor::stereo), HasSubstr("name --right-topic"));
  EXPECT_THAT(chosen({"/a/image"}, {.image = "/a/image", .right = "/a/image"}), HasSubstr("both images"));
  EXPECT_THAT(chosen({"/a/image"}, {.right = "/a/image"}, Sensor::monocular), HasSubstr("--sensor stereo"));
  EXPECT_THAT(chosen({"/a/image"}, {.depth = "/a/image"}, Sensor::monocular), HasSubstr("--sensor rgbd"));
}

TEST(BagTopics, CalibrationsLieBesideTheImages) {
  const auto topics = topics_of(kRealSense);
  EXPECT_EQ(camera_info_of(topics, topics[3])->name, "/camera/color/camera_info");
  EXPECT_EQ(camera_info_of(topics, topics[4])->name, "/camera/color/camera_info") << "of compressed images too";
  EXPECT_EQ(camera_info_of(topics, topics[6]), nullptr);
  EXPECT_EQ(camera_info_name({"image", "sensor_msgs/Image", {}}), "/camera_info");
  EXPECT_TRUE(is_rectified({"/a/image_rect/compressed", "sensor_msgs/CompressedImage", {}}));
  EXPECT_FALSE(is_rectified({"/rectangles/image", "sensor_msgs/Image", {}}));
}

}  // namespace
}  // namespace covis::io
