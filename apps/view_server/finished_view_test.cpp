// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/finished_view.h"

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "covis/core/atomic_file.h"
#include "covis/core/log.h"
#include "covis/core/test_folder.h"

namespace covis::view {
namespace {

TEST(FinishedView, ImagesAreFoundByTheKeyFramesIds) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_atomically(folder / "000012.png", "\x89PNG, a picture"));
  FinishedView view(ViewState(), folder.path());
  KeyFrameRow key_frame;
  key_frame.id = 12;
  EXPECT_EQ(view.key_frame_image(key_frame), "\x89PNG, a picture");
  key_frame.id = 13;
  EXPECT_EQ(view.key_frame_image(key_frame), std::nullopt);
  EXPECT_EQ(FinishedView(ViewState(), "").key_frame_image(key_frame), std::nullopt);
}

// Covis reads more formats than browsers do.
TEST(FinishedView, ImagesThatBrowsersDoNotDecodeAreSentAsJpeg) {
  const TemporaryFolder folder;
  std::string red = "P6\n32 16\n255\n";
  for (int k = 0; k < 32 * 16; ++k) red += std::string("\xff\0\0", 3);
  ASSERT_TRUE(write_atomically(folder / "000000.ppm", red));
  ASSERT_TRUE(write_atomically(folder / "000001.pgm", "P5\n32 16\n255\n" + std::string(32 * 16, '\x5a')));
  ASSERT_TRUE(write_atomically(folder / "000002.pgm", "P5\n32 16\n255\n"));
  FinishedView view(ViewState(), folder.path());
  KeyFrameRow key_frame;
  const std::vector<cv::Vec3b> colours{{0, 0, 255}, {90, 90, 90}};  // blue first
  for (; key_frame.id < 2; ++key_frame.id) {
    const auto jpeg = view.key_frame_image(key_frame);
    ASSERT_TRUE(jpeg && jpeg->starts_with("\xff\xd8")) << key_frame.id;
    const cv::Mat image = cv::imdecode(std::vector<char>(jpeg->begin(), jpeg->end()), cv::IMREAD_COLOR);
    ASSERT_EQ(image.size(), cv::Size(32, 16));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at<cv::Vec3b>(8, 8)[c], colours[key_frame.id][c], 3) << key_frame.id;
  }
  std::vector<std::string> messages;
  set_log_sink([&](LogLevel, std::string_view message) { messages.emplace_back(message); });
  for (int k = 0; k < 2; ++k) EXPECT_EQ(view.key_frame_image(key_frame), std::nullopt);  // it is cut short
  set_log_sink({});
  EXPECT_THAT(messages, testing::ElementsAre(testing::HasSubstr("000002.pgm")));
}

}  // namespace
}  // namespace covis::view
