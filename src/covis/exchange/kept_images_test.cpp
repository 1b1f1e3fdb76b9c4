// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/kept_images.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "covis/core/test_folder.h"

namespace covis::exchange {
namespace {

namespace fs = std::filesystem;

TEST(KeptImages, AreThoseOfTheirMapAndNoOthersAreRemoved) {
  const TemporaryFolder folder;
  auto first = KeptImages::open_to_write(folder / "m.images");
  ASSERT_TRUE(first) << first.error().message;
  for (const char* name : {"000001.png", "000002.jpg"}) write_file(folder / "m.images" / name, name);
  KeptImages kept = first->none();
  kept.add("000001.png", 10'000);
  kept.add("000002.jpg", 20'000);
  ASSERT_TRUE(kept.write_list(*first));
  write_file(folder / "m.images/000009.png", "somebody's");

  auto second = KeptImages::open_to_write(folder / "m.images");
  ASSERT_TRUE(second) << second.error().message;
  EXPECT_EQ(second->find(1, 10'000), folder / "m.images/000001.png");
  EXPECT_EQ(second->find(1, 11'000), fs::path()) << "the key frame of another map";
  EXPECT_EQ(second->find(9, 0), fs::path()) << "it is not in the list";
  KeptImages fewer = second->none();
  fewer.add("000002.jpg", 20'000);
  ASSERT_TRUE(fewer.write_list(*second));
  EXPECT_FALSE(fs::exists(folder / "m.images/000001.png"));
  EXPECT_TRUE(fs::exists(folder / "m.images/000002.jpg"));
  EXPECT_TRUE(fs::exists(folder / "m.images/000009.png"));
}

TEST(KeptImages, AListThatNeverEndsIsRefused) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "images.txt").c_str(), 0600), 0);
  EXPECT_THAT(KeptImages::read(folder.path()).error().message, testing::HasSubstr("images.txt: it is a pipe"));
}

// Found by tools/fuzz.
TEST(KeptImages, ANameThatNoFileCanHaveIsPassedOver) {
  const TemporaryFolder folder;
  write_file(folder / "000001.png", "an image");
  write_file(folder / "images.txt", std::string(300, 'a') + ".png 5\n000001.png 7\n");
  const auto kept = KeptImages::read(folder.path());
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->find(1, 7), folder / "000001.png");
}

TEST(KeptImages, AreNotWrittenIntoAFolderOfOtherThings) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "rec.images");
  write_file(folder / "rec.images/000001.png", "a recording");
  const auto opened = KeptImages::open_to_write(folder / "rec.images");
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, testing::HasSubstr("rec.images: --keep-images would write into"));
  write_file(folder / "file", "");
  EXPECT_FALSE(KeptImages::open_to_write(folder / "file/m.images"));
}

TEST(KeptImages, OfAFolderWithoutAListAreTakenByName) {
  const TemporaryFolder folder;
  write_file(folder / "000001.json", "no image");
  write_file(folder / "000001.JPG", "an image");
  const auto kept = KeptImages::read(folder.path());
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->find(1, 77), folder / "000001.JPG");
  EXPECT_EQ(kept->find(2, 77), fs::path());
  EXPECT_TRUE(kept->check_names({1, 2}));
}

TEST(KeptImages, FramesOfARecordingAreNotTakenForKeyFrames) {
  const TemporaryFolder folder;
  for (const char* name : {"000000.png", "000001.png", "000002.png"}) write_file(folder / name, "a frame");
  const auto kept = KeptImages::read(folder.path());
  ASSERT_TRUE(kept);
  const auto checked = kept->check_names({0, 1});
  ASSERT_FALSE(checked);
  EXPECT_THAT(checked.error().message, testing::HasSubstr("000002.png: no key frame has this number"));
  write_file(folder / "images.txt", "000001.png 7\n");
  EXPECT_TRUE(KeptImages::read(folder.path())->check_names({0})) << "stamps tell whose they are";
}

// A copy can be written over, whatever the rights of its source.
TEST(KeptImages, AreCopiedByTheirBytesAlone) {
  const TemporaryFolder folder;
  write_file(folder / "a.png", "bytes");
  fs::permissions(folder / "a.png", fs::perms::owner_read);
  ASSERT_TRUE(copy_image(folder / "a.png", folder / "b.png"));
  EXPECT_EQ(read_file(folder / "b.png"), "bytes");
  EXPECT_NE(fs::status(folder / "b.png").permissions() & fs::perms::owner_write, fs::perms::none);
  EXPECT_TRUE(copy_image(folder / "a.png", folder / "a.png"));
}

}  // namespace
}  // namespace covis::exchange
