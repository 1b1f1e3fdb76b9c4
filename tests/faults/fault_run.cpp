// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/fault_run.h"

#include <algorithm>
#include <cmath>
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

enum class Certainty { sure, tentative };

// A frame that claims to be somewhere.
struct Claim {
  int frame = 0;
  Timestamp stamp = 0;
  Certainty certainty = Certainty::sure;
  int submap = 0;
  Eigen::Vector3d position;
  double error = 0;  // metres
};

// Each submap is aligned by what it is sure of outside the stretch, or in all, or else by what it claims. A frame
// without a true position has no error.
void find_errors(std::vector<Claim>& all, const GoodRecording& recording, Stretch stretch) {
  const Scale scale = recording.sensor() == Sensor::monocular ? Scale::free : Scale::fixed;
  std::map<int, std::vector<Claim*>> submaps;
  for (Claim& claim : all) submaps[claim.submap].push_back(&claim);
  for (auto& [submap, frames] : submaps) {
    std::vector<Eigen::Vector3d> claimed, truth;
    const auto collect = [&](auto which) {
      claimed.clear();
      truth.clear();
      for (const Claim* claim : frames) {
        const auto position = recording.position(claim->frame);
        if (!position || !which(*claim)) continue;
        claimed.push_back(claim->position);
        truth.push_back(*position);
      }
    };
    const auto is_sure = [](const Claim& claim) { return claim.certainty == Certainty::sure; };
    constexpr size_t kEnough = 10;
    collect([&](const Claim& claim) { return is_sure(claim) && !stretch.has(claim.frame); });
    if (claimed.size() < kEnough) collect(is_sure);
    if (claimed.empty()) {
      collect([](const Claim&) { return true; });
      if (claimed.size() < kEnough) claimed.clear(), truth.clear();  // so few nearly always fit
    }
    const auto alignment = align(claimed, truth, scale);
    for (Claim* claim : frames) {
      const auto position = recording.position(claim->frame);
      if (!position) continue;
      // Without an alignment nobody can say that these poses are right.
      claim->error =
          alignment ? (*alignment * claim->position - *position).norm() : std::numeric_limits<double>::infinity();
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
  std::vector<Claim> claims;
  std::optional<int> first_submap;
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
    const Moment& moment = faulty ? *faulty : good(now);
    const auto tracked = (*slam)->track(frame_of(moment));
    if (!tracked) {
      ++result.refused;
      continue;
    }
    // What was once sure stays a claim to be judged.
    if (const auto from = tracked->retracted_from) {
      std::erase_if(
          claims, [&](const Claim& claim) { return claim.certainty == Certainty::tentative && claim.stamp >= *from; });
    }
    if (!tracked->tracked()) continue;
    const Certainty certainty = tracked->tentative ? Certainty::tentative : Certainty::sure;
    claims.push_back(
        {now, moment.stamp, certainty, tracked->submap, {tracked->pose.x, tracked->pose.y, tracked->pose.z}});
    if (certainty == Certainty::tentative) continue;
    ++(within ? result.sure_within : result.sure_outside);
    if (!first_submap) first_submap = tracked->submap;
    if (now < stretch.end) continue;
    if (result.sure_after < 0) result.sure_after = now - stretch.end;
    if (result.recovered_after < 0 && tracked->submap == *first_submap) result.recovered_after = now - stretch.end;
  }
  (*slam)->finish();
  find_errors(claims, recording, stretch);
  std::vector<double> errors;
  for (const Claim& claim : claims) {
    if (claim.certainty == Certainty::sure && recording.position(claim.frame)) errors.push_back(claim.error);
  }
  result.median_error = quantile(errors, 0.5);
  result.greatest_error = errors.empty() ? 0 : *std::max_element(errors.begin(), errors.end());
  const double of_fault =
      std::min(kMostBound, std::max({0.02, 0.01 * path_length(recording), 5 * result.median_error}));
  const double bound = std::hypot(usual_error, of_fault);
  for (const Claim& claim : claims) {
    const bool is_wrong = claim.error > bound;
    if (claim.certainty == Certainty::sure && is_wrong)
      ++(stretch.has(claim.frame) ? result.wrong_within : result.wrong_outside);
    if (result.found_after < 0 && claim.frame >= stretch.end && !is_wrong && recording.position(claim.frame))
      result.found_after = claim.frame - stretch.end;
  }
  return result;
}

}  // namespace covis::faults
