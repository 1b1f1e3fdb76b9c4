// SPDX-License-Identifier: Apache-2.0
#include "covis/storage/compatibility.h"

#include <gmock/gmock.h>

#include "covis/core/test_folder.h"
#include "covis/storage/test_maps.h"

namespace covis::storage {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Returns the error for a map made with test_header() in a run whose header differs by `change`; empty: it fits.
template <class Change>
std::string problem(Change&& change, MapUse use = MapUse::continuation) {
  MapHeader run = test_header();
  change(run);
  const auto fits = check_compatible(test_header(), run, use);
  return fits ? "" : fits.error().message;
}

TEST(Compatibility, TheSameRunFits) {
  for (const MapUse use : {MapUse::continuation, MapUse::localization}) {
    EXPECT_EQ(problem([](MapHeader&) {}, use), "");
  }
}

TEST(Compatibility, TheUnitOfLengthMustBeTheSame) {
  EXPECT_EQ(problem([](MapHeader& h) { h.sensor = Sensor::stereo; }), "") << "both are in metres";
  const auto without_depth = [](MapHeader& h) { h.sensor = Sensor::monocular; };
  EXPECT_THAT(problem(without_depth), AllOf(HasSubstr("in metres"), HasSubstr("--localize")));
  EXPECT_EQ(problem(without_depth, MapUse::localization), "") << "the map tells the unit";
  MapHeader monocular = test_header();
  monocular.sensor = Sensor::monocular;
  EXPECT_TRUE(check_compatible(monocular, monocular, MapUse::continuation));
  EXPECT_THAT(check_compatible(monocular, test_header(), MapUse::localization).error().message, HasSubstr("arbitrary"));
}

TEST(Compatibility, ThePyramidsMustHaveTheSameFactor) {
  for (const MapUse use : {MapUse::continuation, MapUse::localization}) {
    EXPECT_EQ(problem([](MapHeader& h) { h.levels = 6; }, use), "") << "each key frame has its own";
    EXPECT_THAT(problem([](MapHeader& h) { h.factor = 1.3f; }, use), HasSubstr("orb.scale_factor 1.2;"));
  }
}

TEST(Compatibility, TheCameraMayBeAnother) {
  for (const MapUse use : {MapUse::continuation, MapUse::localization})
    EXPECT_EQ(problem([](MapHeader& h) { h.camera.pinhole.fx = 480; }, use), "");
}

TEST(Compatibility, AMapThatIsContinuedIsOfTheCameraThatContinuesIt) {
  const MapHeader saved = test_header();
  MapHeader run = saved;
  run.camera.pinhole.fx *= 1 + 1e-9;
  EXPECT_EQ(header_after(run, saved).camera.pinhole, saved.camera.pinhole) << "the digits of a file";
  run.camera.pinhole.fx = 480;
  EXPECT_EQ(header_after(run, saved).camera.pinhole.fx, 480);
  run.sensor = Sensor::monocular;
  run.camera.pinhole.bf = 0;
  const MapHeader localised = header_after(run, saved);
  EXPECT_EQ(localised.sensor, saved.sensor) << "it stays in metres";
  EXPECT_NEAR(localised.camera.pinhole.baseline(), saved.camera.pinhole.baseline(), 1e-12);
}

TEST(Compatibility, MapsOfAnyCamerasAreMergedWithFeaturesOfOneKind) {
  MapHeader other = test_header();
  other.camera.distortion = Distortion::none;
  EXPECT_TRUE(check_mergeable(test_header(), other));
  other = test_header();
  other.sensor = Sensor::monocular;
  EXPECT_TRUE(check_mergeable(test_header(), other));
  other.levels = 4;
  EXPECT_TRUE(check_mergeable(test_header(), other));
  other.factor = 1.5f;
  EXPECT_THAT(check_mergeable(test_header(), other).error().message, HasSubstr("orb.scale_factor 1.5 instead of 1.2"));
}

TEST(Compatibility, TheVocabularyMayBeAnother) {
  EXPECT_EQ(problem([](MapHeader& h) { h.vocabulary.clear(); }), "");
}

TEST(Compatibility, LoadsWhatFitsAndNamesTheFile) {
  const TemporaryFolder folder;
  ASSERT_TRUE(save_map(folder / "m", random_map(1, 60).state(), test_header()));
  const auto fits = load_compatible_map(folder / "m", test_header(), MapUse::continuation);
  ASSERT_TRUE(fits) << fits.error().message;
  EXPECT_GT(fits->map.key_frame_count(), 0u);
  MapHeader other = test_header();
  other.factor = 1.5f;
  EXPECT_THAT(load_compatible_map(folder / "m", other, MapUse::continuation).error().message,
              AllOf(HasSubstr("m: the map was made"), HasSubstr("orb.scale_factor 1.2")));
  ASSERT_TRUE(save_map(folder / "empty", Map().state(), test_header()));
  EXPECT_THAT(load_compatible_map(folder / "empty", test_header(), MapUse::localization).error().message,
              HasSubstr("empty: the map is empty"));
  EXPECT_FALSE(load_compatible_map(folder / "none", test_header(), MapUse::localization));
}

}  // namespace
}  // namespace covis::storage
