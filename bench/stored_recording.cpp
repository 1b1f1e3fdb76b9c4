// SPDX-License-Identifier: Apache-2.0
#include "bench/stored_recording.h"

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "covis/eval/evaluation.h"

namespace covis::faults {

Result<StoredRecording> StoredRecording::read(const std::filesystem::path& folder, const io::SequenceOptions& options) {
  auto sequence = io::open_sequence(folder.string(), options);
  if (!sequence) return tl::unexpected(sequence.error());
  const auto truth = io::load_truth(**sequence);
  if (!truth) return tl::unexpected(truth.error());
  StoredRecording recording;
  recording.sensor_ = (*sequence)->sensor();
  recording.camera_ = (*sequence)->camera();
  Trajectory stamps;
  for (;;) {
    auto frame = (*sequence)->next();
    if (!frame) return tl::unexpected(frame.error());
    if (!*frame) break;
    stamps.push_back({(*frame)->stamp, SE3()});
    recording.frames_.push_back(
        {std::move((*frame)->image), std::move((*frame)->right), std::move((*frame)->depth), (*frame)->stamp});
  }
  const auto evaluation = evaluate(stamps, *truth, {.align = AlignMode::none});
  if (!evaluation) return tl::unexpected(evaluation.error());
  std::map<Timestamp, Eigen::Vector3d> positions;
  for (const ComparedPose& pose : evaluation->compared) positions[pose.stamp] = pose.truth.t();
  for (const StampedPose& frame : stamps) {
    const auto at = positions.find(frame.stamp);
    recording.positions_.push_back(at == positions.end() ? std::nullopt : std::optional(at->second));
  }
  return recording;
}

const Moment& StoredRecording::operator()(int i) { return frames_[static_cast<size_t>(std::clamp(i, 0, size() - 1))]; }

}  // namespace covis::faults
