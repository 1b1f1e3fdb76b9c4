// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/key_frame_colours.h"

#include <gtest/gtest.h>

#include "covis/map/test_map.h"

namespace covis {
namespace {

TEST(KeyFrameColours, AreThoseOfTheImagesOfTheirFrames) {
  MapFixture made;
  const KeyFrameId loaded = made.frame(0), own = made.frame(1), other = made.frame(2);
  SharedMap map;
  *map.write() = std::move(made.map);
  KeyFrameColours colours(map);
  colours.map_loaded(map.read()->at(own).serial);
  const std::vector<uint8_t> pixels(640 * 480 * 3, 77);
  std::vector<int64_t> asked;
  const auto fill = [&](int width) {
    asked.clear();
    return colours.fill(width, 480, [&](int64_t frame) -> std::optional<ColourImage> {
      asked.push_back(frame);
      if (frame != map.read()->at(own).frame) return std::nullopt;
      return ColourImage{pixels.data(), 640, 480, 640 * 3};
    });
  };
  EXPECT_EQ(fill(320), 0u) << "the image is of another size";
  EXPECT_EQ(fill(640), 1u);
  EXPECT_EQ(asked, (std::vector<int64_t>{10, 20})) << "the loaded one's frame is of another recording";
  const KeyFrame& key_frame = map.read()->at(own);
  ASSERT_TRUE(key_frame.colours);
  EXPECT_EQ(key_frame.colours->size(), static_cast<size_t>(key_frame.features->size()));
  EXPECT_EQ(key_frame.colours->front(), (Colour{77, 77, 77}));
  EXPECT_FALSE(map.read()->at(loaded).colours || map.read()->at(other).colours);
  EXPECT_EQ(fill(640), 0u);
  EXPECT_EQ(asked, (std::vector<int64_t>{20})) << "what has colours is not asked for again";
}

}  // namespace
}  // namespace covis
