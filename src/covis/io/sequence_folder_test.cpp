// SPDX-License-Identifier: Apache-2.0
#include "covis/io/files.h"
#include "covis/io/test_recordings.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST_F(Sequences, StopsDecodingAtAnyTime) {
  kitti(20);
  for (int k = 0; k < 30; ++k) {
    auto opened = open({.decode_ahead = 1 + k % 4});
    for (int i = 0; i < k % 5; ++i) (*opened)->next();
  }
}

TEST_F(Sequences, UsesMemoryOfAnotherRecordingWithoutItsDepth) {
  tum();
  auto rgbd = open();
  Frame memory = std::move(**(*rgbd)->next());
  ASSERT_FALSE(memory.depth.empty());
  auto mono = open({.sensor = Sensor::monocular, .decode_ahead = 1});
  for (int i = 0; i < 3; ++i) {
    auto frame = (*mono)->next(std::move(memory));
    ASSERT_TRUE(frame && *frame);
    EXPECT_TRUE((*frame)->depth.empty());
    memory = std::move(**frame);
  }
}

TEST_F(Sequences, GiveTheirPicturesByFrame) {
  tum(6);
  auto opened = open({.first = 1, .stride = 2});
  for (auto frame = (*opened)->next(); frame && *frame; frame = (*opened)->next()) {
    const auto picture = (*opened)->picture((*frame)->index);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->row(3)[3], (*frame)->image(1, 3));
    EXPECT_TRUE((*opened)->may_have_colours((*frame)->index));
  }
  EXPECT_FALSE((*opened)->picture(0)) << "it is not read";
  EXPECT_FALSE((*opened)->picture(99));
}

TEST_F(BadInput, OneTruncatedImage) {
  tum();
  const std::string whole = *read_text(folder / "rgb/1.png");
  write("rgb/1.png", whole.substr(0, whole.size() / 2));
  auto opened = open();
  ASSERT_TRUE(opened);
  EXPECT_TRUE((*opened)->next());
  const auto bad = (*opened)->next();
  ASSERT_FALSE(bad);
  EXPECT_THAT(bad.error().message, AllOf(HasSubstr("1.png"), HasSubstr("cut short")));
  const auto after = (*opened)->next();
  ASSERT_TRUE(after && *after);
  EXPECT_EQ((*after)->index, 2);
}

TEST_F(BadInput, NotAnImage) {
  tum();
  write("rgb/0.png", "hello");
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr("0.png"), HasSubstr("not an image")));
  write("rgb/0.png", "");
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr("0.png"), HasSubstr("empty")));
}

TEST_F(BadInput, ImageOfAnotherSize) {
  tum();
  image("rgb/0.png", 1, 32, 24);
  EXPECT_THAT((*open())->next().error().message, AllOf(HasSubstr("0.png"), HasSubstr("32x24"), HasSubstr("64x48")));
}

}  // namespace
}  // namespace covis::io
