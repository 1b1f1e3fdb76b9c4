// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/live_view.h"

#include <gmock/gmock.h>

#include <string>
#include <thread>
#include <vector>

#include "covis/core/log.h"

namespace covis::view {
namespace {

using testing::SizeIs;

struct TrackedFrames {
  TrackedFrames() : system(Camera{64, 48, {50, 50, 32, 24, 4}}, SystemOptions()) {}

  // As if it had been tracked at x.
  void track(LiveView& live, int64_t frame, bool key_frame, int height = 48) {
    io::Frame image;
    image.index = frame;
    image.image.resize(64, height);
    FrameReport report;
    report.track.state = TrackingState::tracking;
    report.track.key_frame = key_frame;
    report.track.T_cw = SE3(Eigen::Matrix3d::Identity(), {-static_cast<double>(frame), 0, 0});
    live.frame_tracked(app::tracked_frame(image, report, app::RunMode::mapping), image, report);
  }
  System system;
};

TEST(LiveView, WhatTrackingLeftIsShown) {
  TrackedFrames frames;
  LiveView live("{}");
  live.run_begins(frames.system);
  frames.track(live, 0, true);
  frames.track(live, 1, false);
  live.frame_skipped(app::skipped_frame(2, 0, app::FrameState::late, "too late"));
  const ViewState& state = live.refresh();
  ASSERT_THAT(state.log.frames(), SizeIs(3));
  EXPECT_FLOAT_EQ(state.log.frames()[1].pose.t[0], 1);
  EXPECT_EQ(state.log.texts()[state.log.frames()[2].reason], "too late");
  KeyFrameRow key_frame;
  EXPECT_TRUE(live.key_frame_image(key_frame).has_value());
  key_frame.frame = 1;
  EXPECT_FALSE(live.key_frame_image(key_frame).has_value());
}

TEST(LiveView, ImagesAreCopiedOnlyWhenAPageWantsThem) {
  TrackedFrames frames;
  LiveView live("{}");
  live.run_begins(frames.system);
  frames.track(live, 0, false);
  live.tidy();
  EXPECT_EQ(live.refresh().image.frame, -1);
  // refresh() asks for one when the last is old enough; the test asks until it does.
  int64_t next = 1;
  while (live.refresh().image.frame < 0) frames.track(live, next++, false);
  EXPECT_GT(live.refresh().image.jpeg.size(), 0u);
}

TEST(LiveView, ThatImagesCantBeEncodedIsToldOnce) {
  TrackedFrames frames;
  LiveView live("{}");
  live.run_begins(frames.system);
  std::vector<std::string> said;
  set_log_sink([&](LogLevel, std::string_view text) { said.emplace_back(text); });
  for (int64_t k = 0; k < 3; ++k) frames.track(live, k, true, 70000);  // a JPEG has 65500 rows at most
  live.tidy();
  frames.track(live, 3, true, 70000);
  live.tidy();
  set_log_sink({});
  ASSERT_THAT(said, SizeIs(1));
  EXPECT_THAT(said[0], testing::StartsWith("viewer: it can't show images: "));
  EXPECT_EQ(live.key_frame_image(KeyFrameRow()), std::nullopt);
}

TEST(LiveView, TrackingAndTheServerNeverMeet) {
  TrackedFrames frames;
  LiveView live("{}");
  live.run_begins(frames.system);
  {
    const std::jthread server([&] {
      while (live.refresh().log.frames().size() < 300) live.tidy();
    });
    for (int64_t k = 0; k < 300; ++k) frames.track(live, k, k % 10 == 0);
  }
  live.run_ended(ViewState());
  EXPECT_THAT(live.refresh().log.frames(), SizeIs(0));
}

TEST(LiveView, TheLastStateTakesThePlaceOfAll) {
  TrackedFrames frames;
  LiveView live("{}");
  live.run_begins(frames.system);
  frames.track(live, 0, false);
  const uint64_t before = live.refresh().info_version;
  ViewState last;
  last.info = "{\"mode\":\"finished\"}";
  live.run_ended(std::move(last));
  EXPECT_THAT(live.refresh().log.frames(), SizeIs(0));
  EXPECT_GT(live.refresh().info_version, before);
}

}  // namespace
}  // namespace covis::view
