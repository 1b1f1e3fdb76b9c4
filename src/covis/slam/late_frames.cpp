// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/late_frames.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

#include "covis/slam/path_reach.h"

namespace covis {

void LateFrames::keep(std::vector<UnlocatedFrame> frames) {
  constexpr size_t kMost = 180;  // as in the backlog of tracking
  frames_.insert(frames_.end(), std::make_move_iterator(frames.rbegin()), std::make_move_iterator(frames.rend()));
  if (frames_.size() > kMost) frames_.erase(frames_.begin(), frames_.end() - kMost);
}

std::vector<LocatedFrame> LateFrames::locate(Relocaliser relocaliser, std::vector<PoseOfFrame> known) {
  constexpr size_t kFewest = 5;  // frames in a row
  std::vector<UnlocatedFrame> frames = std::exchange(frames_, {});
  std::vector<LocatedFrame> located, row;
  if (frames.size() < kFewest) return located;
  PathReach believed(std::move(known)), reach = believed;
  const auto end_row = [&] {
    if (row.empty()) return;
    const bool is_believed = row.size() >= kFewest;
    if (is_believed) located.insert(located.end(), row.begin(), row.end());
    (is_believed ? believed : reach) = is_believed ? reach : believed;
    row.clear();
  };
  Timestamp last = 0;  // the row's last one
  std::ranges::sort(frames, std::greater(), &UnlocatedFrame::frame);
  for (const UnlocatedFrame& frame : frames) {
    const auto found = relocaliser.locate(frame.features, frame.frame);
    const PoseOfFrame pose{
        {found ? found->T_cw.inverse() : SE3(), found ? found->submap : 0}, frame.frame, frame.stamp};
    if (to_seconds(last) - to_seconds(frame.stamp) > reach.longest()) end_row();
    if (found && reach.admits(pose)) {
      reach.add(pose);
      last = frame.stamp;
      row.push_back({frame.frame, found->pose});
    } else {
      end_row();
    }
  }
  end_row();
  return located;
}

}  // namespace covis
