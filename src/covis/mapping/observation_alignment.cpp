// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/observation_alignment.h"

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "covis/map/anchors.h"
#include "covis/matching/patch_alignment.h"

namespace covis {
namespace {

// The newest key frames of whatever submap that keep all their patches, and those that keep some: so the memory of
// patches is bounded.
constexpr uint32_t kNew = 16, kKeepSome = 256;

// The features of a key frame with new places for those that can be aligned; null where there is nothing new. What key
// frames show anew are points that the newest one shows too.
FeaturesPtr aligned(const Map& map, KeyFrameId id, KeyFrameId newest) {
  const KeyFrame& key_frame = map.at(id);
  const Features& f = *key_frame.features;
  std::shared_ptr<Features> made;
  for (uint32_t i = 0; i < key_frame.points.size(); ++i) {
    if (!key_frame.points[i].valid()) continue;
    const MapPoint& point = map.at(key_frame.points[i]);
    if (point.reference == id || (id != newest && !point.seen_by(newest))) continue;
    const KeyFrame& reference = map.at(point.reference);
    const uint32_t seen = point.feature_in(point.reference);
    const uint64_t anchor = anchor_of(reference, seen);
    if (anchor_of(key_frame, i) == anchor) continue;
    const auto question = PatchQuestion::of(map.camera(), *reference.features, seen, reference.T_cw * point.position_w,
                                            key_frame.T_cw * reference.T_cw.inverse(), f, i);
    const auto place = question ? question->answer(f, i) : std::nullopt;
    if (!place) continue;
    if (!made) {
      made = std::make_shared<Features>(f);
      made->anchor.resize(f.x.size(), 0);
    }
    made->anchor[i] = anchor;
    made->x[i] = place->undistorted.x();
    made->y[i] = place->undistorted.y();
    if (!made->raw_x.empty()) {
      made->raw_x[i] = place->image.x();
      made->raw_y[i] = place->image.y();
    }
    if (f.depth[i] > 0) made->u_right[i] += place->undistorted.x() - f.x[i];
  }
  if (made) made->grid.build(f.grid.bounds, made->x, made->y);
  return made;
}

// The features of a key frame with the patches of points whose reference it is, and no others.
FeaturesPtr with_few_patches(const Map& map, KeyFrameId id) {
  const KeyFrame& key_frame = map.at(id);
  auto made = std::make_shared<Features>(*key_frame.features);
  const Patches& all = *std::exchange(made->patches, nullptr);
  auto kept = std::make_shared<Patches>();
  for (uint32_t i = 0; i < key_frame.points.size(); ++i) {
    const MapPoint* point = key_frame.points[i].valid() ? &map.at(key_frame.points[i]) : nullptr;
    if (!point || point->reference != id) continue;
    kept->features.push_back(static_cast<uint16_t>(i));
    kept->at.push_back(all.at[i]);
  }
  kept->stretch = all.stretch;
  kept->at.shrink_to_fit();
  kept->features.shrink_to_fit();
  if (!kept->at.empty()) made->patches = std::move(kept);
  return made;
}

FeaturesPtr without_patches(const Features& features) {
  auto made = std::make_shared<Features>(features);
  made->patches = nullptr;
  return made;
}

using NewFeatures = std::vector<std::pair<KeyFrameId, FeaturesPtr>>;

NewFeatures new_features(const Map& map, KeyFrameId newest) {
  NewFeatures made;
  const uint32_t serial = map.at(newest).serial;
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    const std::shared_ptr<Patches>& patches = key_frame.features->patches;
    if (!patches) return;
    if (key_frame.serial + kKeepSome <= serial) {
      made.emplace_back(id, without_patches(*key_frame.features));
    } else if (key_frame.serial + kNew > serial) {
      if (FeaturesPtr features = aligned(map, id, newest)) made.emplace_back(id, std::move(features));
    } else if (patches->features.empty()) {
      made.emplace_back(id, with_few_patches(map, id));
    }
  });
  return made;
}

}  // namespace

void align_observations(SharedMap& shared, KeyFrameId newest) {
  const NewFeatures made = new_features(*shared.read(), newest);
  if (made.empty()) return;
  const auto map = shared.write();
  for (const auto& [id, features] : made) map->set_features(id, features);
}

}  // namespace covis
