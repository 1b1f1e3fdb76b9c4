// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/finished_view.h"

#include <gmock/gmock.h>

#include "covis/core/atomic_file.h"
#include "covis/core/test_folder.h"

namespace covis::view {
namespace {

TEST(FinishedView, ImagesAreFoundByTheKeyFramesIds) {
  const TemporaryFolder folder;
  ASSERT_TRUE(write_atomically(folder / "000012.png", "a picture"));
  FinishedView view(ViewState(), folder.path());
  KeyFrameRow key_frame;
  key_frame.id = 12;
  EXPECT_EQ(view.key_frame_image(key_frame), "a picture");
  key_frame.id = 13;
  EXPECT_EQ(view.key_frame_image(key_frame), std::nullopt);
  EXPECT_EQ(FinishedView(ViewState(), "").key_frame_image(key_frame), std::nullopt);
}

}  // namespace
}  // namespace covis::view
