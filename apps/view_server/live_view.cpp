// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/live_view.h"

#include <algorithm>

#include "apps/run/run_view.h"
#include "covis/core/log.h"

namespace covis::view {
namespace {

constexpr double kImageInterval = 80;                   // ms between two images that are asked for
constexpr double kMapInterval = 500;                    // ms at least between two readings of the map
constexpr double kMapShare = 20;                        // and this many times as long as the last one took
constexpr int kImageWidth = 480, kKeyFrameWidth = 320;  // pixels
constexpr size_t kMostWaiting = 16;                     // images of key frames that wait to be encoded

KeypointRow row_of(const ViewedKeypoint& keypoint) {
  const auto quarters = [](float pixel) {
    return static_cast<uint16_t>(std::clamp(kPixelUnits * pixel, 0.0f, 65535.0f));
  };
  return {quarters(keypoint.u), quarters(keypoint.v), static_cast<KeypointKind>(keypoint.kind)};
}

}  // namespace

LiveView::LiveView(std::string info) { state_.info = std::move(info); }

void LiveView::run_begins(const System& system) {
  first_own_ = system.map().read()->next_serial();
  const std::lock_guard lock(system_mutex_);
  system_ = &system;
}

void LiveView::frame_tracked(const app::FrameStats& stats, const io::Frame& frame, const FrameReport& report) {
  FrameRow row = app::row_of(stats);
  if (report.track.state == TrackingState::tracking) {
    row.flags |= FrameRow::kHasPose;
    row.pose = view::row_of(report.track.T_cw.inverse());
    row.submap = report.track.submap;
  }
  std::optional<RawImage> image, key_frame;
  if (image_wanted_.exchange(false)) {
    image.emplace(row.frame, frame.image.view());
    // The tracking thread alone may ask for them, so it does not need the lock.
    for (const ViewedKeypoint& keypoint : system_->viewed_keypoints()) image->keypoints.push_back(row_of(keypoint));
  }
  if (stats.track.key_frame) key_frame.emplace(row.frame, frame.image.view());
  const std::lock_guard lock(inbox_mutex_);
  inbox_.frames.emplace_back(row, stats.reason);
  if (image) inbox_.image = std::move(image);
  if (key_frame && inbox_.key_frames.size() < kMostWaiting) inbox_.key_frames.push_back(std::move(*key_frame));
}

void LiveView::frame_skipped(const app::FrameStats& stats) {
  const std::lock_guard lock(inbox_mutex_);
  inbox_.frames.emplace_back(app::row_of(stats), stats.reason);
}

void LiveView::loops_changed(const std::vector<LoopPaths>& loops) {
  const std::lock_guard lock(inbox_mutex_);
  inbox_.loops = loops;
}

void LiveView::run_ended(ViewState last) {
  {
    const std::lock_guard lock(system_mutex_);
    system_ = nullptr;
  }
  const std::lock_guard lock(inbox_mutex_);
  inbox_.last = std::move(last);
}

const ViewState& LiveView::refresh() {
  take_inbox();
  read_map();
  if (since_image_.ms() >= kImageInterval && !image_wanted_) {
    since_image_.restart();
    image_wanted_ = true;
  }
  return state_;
}

void LiveView::tidy() { take_inbox(); }

std::optional<std::string> LiveView::key_frame_image(const KeyFrameRow& key_frame) {
  // Frames of key frames that came with a map are of another recording.
  return key_frame.id < first_own_ ? std::nullopt : images_.get(key_frame.frame);
}

void LiveView::take_inbox() {
  Inbox inbox;
  {
    const std::lock_guard lock(inbox_mutex_);
    std::swap(inbox, inbox_);
  }
  for (const auto& [row, reason] : inbox.frames) state_.log.add(row, reason);
  if (!inbox.loops.empty()) state_.log.set_loops(inbox.loops);
  encode(inbox);
  if (!inbox.last) return;
  // Frames may have got their poses afterwards, so the page begins anew with the list of them.
  inbox.last->info_version = state_.info_version + 1;
  inbox.last->image = std::move(state_.image);
  state_ = std::move(*inbox.last);
}

void LiveView::encode(Inbox& inbox) {
  if (inbox.image) {
    state_.image = {inbox.image->frame, static_cast<uint32_t>(inbox.image->grey.width()),
                    static_cast<uint32_t>(inbox.image->grey.height()), std::move(inbox.image->keypoints),
                    encoded(*inbox.image, kImageWidth)};
  }
  for (const RawImage& image : inbox.key_frames) {
    if (std::string jpeg = encoded(image, kKeyFrameWidth); !jpeg.empty()) images_.put(image.frame, std::move(jpeg));
  }
}

std::string LiveView::encoded(const RawImage& image, int width) {
  auto jpeg = jpeg_of(image.grey.view(), width);
  if (jpeg) return std::move(*jpeg);
  if (!std::exchange(problem_logged_, true))
    log(LogLevel::warning, "viewer: it can't show images: " + jpeg.error().message);
  return {};
}

void LiveView::read_map() {
  if (reading_.since.ms() < reading_.wait_ms) return;
  const std::lock_guard lock(system_mutex_);
  if (!system_) return;
  const Stopwatch cost;
  std::shared_ptr<const Snapshot> snapshot = system_->snapshot();
  if (snapshot != reading_.snapshot) state_.map = std::make_shared<const MapScene>(scene_of(*snapshot));
  reading_.snapshot = std::move(snapshot);
  reading_.wait_ms = std::max(kMapInterval, kMapShare * cost.ms());
  reading_.since.restart();
}

}  // namespace covis::view
