// SPDX-License-Identifier: Apache-2.0
#include "covis/io/plugin.h"

#include <gmock/gmock.h>

#include "covis/io/bag.h"
#include "covis/io/codecs.h"
#include "covis/io/video_file.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Plugins, StayOpen) {
  const auto codecs = plugin<CodecPlugin>();
  ASSERT_TRUE(codecs) << codecs.error().message;
  EXPECT_EQ(*plugin<CodecPlugin>(), *codecs);
  EXPECT_TRUE(plugin<VideoPlugin>());
  EXPECT_EQ(plugin<Ros1BagPlugin>().has_value(), reads_ros1_bags());
}

TEST(Plugins, OneThatIsMissingIsNamedWithItsPurposeAndPackages) {
  const auto opened = open_plugin("covis_smell", "reads smells");
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, AllOf(HasSubstr("covis_smell.so, which reads smells, can't be opened: /"),
                                            HasSubstr("No such file"), HasSubstr("Debian's package covis")));
}

TEST(Plugins, EncodeAnImage) {
  const cv::Mat image(4, 4, CV_8U, cv::Scalar(1));
  EXPECT_THAT(encode_image(".png", image).value_or(""), HasSubstr("PNG"));
}

}  // namespace
}  // namespace covis::io
