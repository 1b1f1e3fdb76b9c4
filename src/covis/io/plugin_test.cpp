// SPDX-License-Identifier: Apache-2.0
#include "covis/io/plugin.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "covis/io/bag.h"
#include "covis/io/codecs.h"
#include "covis/io/video_file.h"
#include "tests/plugin/small.h"

namespace covis::io {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::MatchesRegex;

TEST(Plugins, OfTheBuildAreFound) {
  for (const auto& problem : {plugin<CodecPlugin>().map([](auto) {}), plugin<VideoPlugin>().map([](auto) {})})
    EXPECT_TRUE(problem) << problem.error().message;
  EXPECT_EQ(plugin<Ros1BagPlugin>().has_value(), reads_ros1_bags());
}

TEST(Plugins, OneThatIsInstalledLaterIsFoundAndStaysOpen) {
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path(), late = folder / "covis_late.so";
  fs::remove(late);
  EXPECT_FALSE(plugin<SmallPlugin>());
  fs::copy_file(folder / "covis_small.so", late);
  const auto found = plugin<SmallPlugin>();
  fs::remove(late);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ((*found)->twice(21), 42);
  EXPECT_EQ(plugin<SmallPlugin>().value_or(nullptr), *found) << "although its file is gone";
}

TEST(Plugins, OneThatIsMissingIsNamedWithItsPurposeAndPackages) {
  const auto opened = open_plugin("covis_smell", "reads smells");
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, AllOf(HasSubstr("covis_smell.so, which reads smells, can't be opened: /"),
                                            HasSubstr("No such file"), HasSubstr("Debian's package covis")));
}

TEST(Plugins, OneOfAnotherVersionIsRefused) {
  const auto opened = open_plugin("covis_older", "doubles numbers");
  ASSERT_FALSE(opened);
  EXPECT_THAT(
      opened.error().message,
      MatchesRegex("covis_older.so, which doubles numbers, can't be used: /.*/covis_older.so is of Covis 0.0.1, "
                   "and this is Covis [0-9.]+. It is installed .*"));
}

TEST(Plugins, ALibraryThatIsNoneIsRefused) {
  const auto opened = open_plugin("covis_foreign", "does nothing");
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, HasSubstr("covis_foreign.so does not say its version"));
}

TEST(Plugins, EncodeAnImage) {
  const cv::Mat image(4, 4, CV_8U, cv::Scalar(1));
  EXPECT_THAT(encode_image(".png", image).value_or(""), HasSubstr("PNG"));
}

}  // namespace
}  // namespace covis::io
