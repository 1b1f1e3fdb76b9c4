// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/fault_run.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "covis/api/convert.h"
#include "covis/core/quantile.h"
#include "covis/covis.h"
#include "covis/geometry/alignment.h"

namespace covis::faults {
namespace {

constexpr double kMostBound = 0.1;  // metres; a run whose median is wrong does not excuse itself
constexpr uint64_t kStage = 100;    // stage of random numbers, above those of the library

SlamOptions options_of(const GoodRecording& recording) {
  SlamOptions options;
  options.sensor = recording.sensor() == Sensor::monocular ? SensorType::monocular
                   : recording.sensor() == Sensor::stereo  ? SensorType::stereo
                                                           : SensorType::rgbd;
  options.camera = to_parameters(recording.camera());
  options.timing = Timing::deterministic;
  options.vocabulary = COVIS_SOURCE_DIR "/vocabulary/default.covis-voc";
  return options;
}

Frame frame_of(const Moment& m) {
  Frame frame{.stamp = m.stamp};
  frame.image = {m.left.view().data, m.left.width(), m.left.height(), m.left.stride()};
  if (!m.right.empty()) frame.right = {m.right.view().data, m.right.width(), m.right.height(), m.right.stride()};
  if (!m.depth.empty()) frame.depth = {m.depth.view().data, m.depth.width(), m.depth.height(), m.depth.stride()};
  return frame;
}

// A frame that claims to know where it is.
struct Sure {
  int frame = 0;
  int submap = 0;
  Eigen::Vector3d position;
  double error = 0;  // metres
};

// Each submap is aligned by what it claims outside the stretch. A frame without a true position has no error.
void find_errors(std::vector<Sure>& all, const GoodRecording& recording, Stretch stretch) {
  const Scale scale = recording.sensor() == Sensor::monocular ? Scale::free : Scale::fixed;
  std::map<int, std::vector<Sure*>> submaps;
  for (Sure& sure : all) submaps[sure.submap].push_back(&sure);
  for (auto& [submap, frames] : submaps) {
    std::vector<Eigen::Vector3d> claimed, truth;
    const auto collect = [&](bool outside_only) {
      for (const Sure* sure : frames) {
        const auto position = recording.position(sure->frame);
        if (!position || (outside_only && stretch.has(sure->frame))) continue;
        claimed.push_back(sure->position);
        truth.push_back(*position);
      }
    };
    collect(true);
    if (claimed.size() < 10) {
      claimed.clear();
      truth.clear();
      collect(false);
    }
    const auto alignment = align(claimed, truth, scale);
    if (!alignment) {  // nobody can say that these poses are right
      for (Sure* sure : frames) {
        if (recording.position(sure->frame)) sure->error = std::numeric_limits<double>::infinity();
      }
      continue;
    }
    for (Sure* sure : frames) {
      if (const auto position = recording.position(sure->frame))
        sure->error = (*alignment * sure->position - *position).norm();
    }
  }
}

double path_length(const GoodRecording& recording) {
  double length = 0;
  std::optional<Eigen::Vector3d> last;
  for (int i = 0; i < recording.size(); ++i) {
    const auto position = recording.position(i);
    if (position && last) length += (*position - *last).norm();
    if (position) last = position;
  }
  return length;
}

}  // namespace

RenderedRecording::RenderedRecording(const SynthOptions& options, int frames, std::optional<int> turn)
    : synth_(std::move(Synth::create(options).value())), turn_(turn), frames_(static_cast<size_t>(frames)) {}

const Moment& RenderedRecording::operator()(int i) {
  Moment& moment = frames_[static_cast<size_t>(std::clamp(i, 0, size() - 1))];
  if (!moment.left.empty()) return moment;
  const int at = static_cast<int>(&moment - frames_.data());
  synth_.render(place(at), moment.left, synth_.sensor() == Sensor::stereo ? &moment.right : nullptr,
                synth_.sensor() == Sensor::rgbd ? &moment.depth : nullptr);
  moment.stamp = synth_.stamp(at);
  return moment;
}

FaultResult run_fault(GoodRecording& recording, const Fault& fault, Stretch stretch, double usual_error) {
  const GoodFrames good = [&](int i) -> const Moment& { return recording(i); };
  auto slam = Slam::create(options_of(recording));
  if (!slam) {
    std::fprintf(stderr, "%s\n", slam.error().c_str());
    std::abort();
  }
  FaultResult result;
  std::vector<Sure> sure;
  int now = 0;
  (*slam)->on_event([&](const Event& event) {
    if (event.kind == Event::Kind::sensor_doubted && result.warned_after < 0) result.warned_after = now - stretch.first;
  });
  for (now = 0; now < recording.size(); ++now) {
    const bool within = stretch.has(now);
    std::optional<Moment> faulty;
    if (within) {
      Random random(hash_seed(1, kStage, static_cast<uint64_t>(now)));
      faulty = fault.at(now, good, random);
      if (!faulty) continue;
    }
    ++(within ? result.within : result.outside);
    const auto tracked = (*slam)->track(frame_of(faulty ? *faulty : good(now)));
    if (!tracked) {
      ++result.refused;
      continue;
    }
    if (!tracked->tracked() || tracked->tentative) continue;
    ++(within ? result.sure_within : result.sure_outside);
    sure.push_back({now, tracked->submap, {tracked->pose.x, tracked->pose.y, tracked->pose.z}});
    if (now < stretch.end) continue;
    if (result.sure_after < 0) result.sure_after = now - stretch.end;
    if (result.recovered_after < 0 && tracked->submap == sure.front().submap)
      result.recovered_after = now - stretch.end;
  }
  (*slam)->finish();
  find_errors(sure, recording, stretch);
  std::vector<double> errors;
  for (const Sure& s : sure) {
    if (recording.position(s.frame)) errors.push_back(s.error);
  }
  result.median_error = quantile(errors, 0.5);
  result.greatest_error = errors.empty() ? 0 : *std::max_element(errors.begin(), errors.end());
  const double bound = std::max(
      usual_error, std::min(kMostBound, std::max({0.02, 0.01 * path_length(recording), 5 * result.median_error})));
  for (const Sure& s : sure) {
    if (s.error > bound) ++(stretch.has(s.frame) ? result.wrong_within : result.wrong_outside);
  }
  return result;
}

}  // namespace covis::faults
