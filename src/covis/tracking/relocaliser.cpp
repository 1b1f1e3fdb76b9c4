// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/relocaliser.h"

#include <algorithm>
#include <utility>

namespace covis {
namespace {

constexpr int kMinInliers = 10;  // map points that make a pose worth a search by projection

}  // namespace

Relocaliser::Relocaliser(const SharedMap& map, const TrackerOptions& options, int seed,
                         std::shared_ptr<const Vocabulary> vocabulary)
    : map_(map), options_(options), seed_(seed), vocabulary_(std::move(vocabulary)) {}

std::optional<Relocaliser::Located> Relocaliser::locate(FeaturesPtr features, int64_t frame, const ImageProbe* probe) {
  PoseSearch search(options_.recovery, Subject::single_image);
  search.image = probe;
  search.refresh_camera(*map_.read());
  TrackedFrame image;
  image.start(std::move(features), frame, 0);
  image.straighten_for(search.camera);
  TrackFigures figures;
  if (!find(image, search, &map_, {}, figures)) return std::nullopt;
  const KeyFrameView& near = search.local_map.reference;
  return Located{image.T_cw, near.submap, figures.inliers, image.information,
                 RelativePose{near.id, near.scale, image.T_cw * near.T_cw.inverse()}};
}

bool Relocaliser::find(TrackedFrame& frame, PoseSearch& search, const SharedMap* live, const Where& where,
                       TrackFigures& figures) {
  LocalMap& local_map = search.local_map;
  if (!live) {
    const KeyFrameView& reference = local_map.reference;
    return reference.features && reference.submap != where.but && find_at(reference, frame, search, live, figures);
  }
  std::optional<Words> words;  // before the guard: it takes long
  if (vocabulary_) words = vocabulary_->transform(frame.features->descriptor);
  const std::vector<KeyFrameId> places = candidates(*live->read(), words ? &*words : nullptr, where);
  KeyFrameView view;
  for (const KeyFrameId& place : places) {
    {
      const auto map = live->read();
      if (!map->find(place)) continue;
      view.copy(*map, place);
    }
    if (find_at(view, frame, search, live, figures)) return true;
  }
  // The candidates leave no reference behind; the rest of the local map is made anew for each frame.
  if (const auto map = live->read(); map->find(where.near)) local_map.reference.copy(*map, where.near);
  return false;
}

std::vector<KeyFrameId> Relocaliser::candidates(const Map& map, const Words* words, const Where& where) {
  constexpr size_t kAlike = 8;                         // most key frames found by words
  constexpr int kNeighbours = 3;                       // neighbours of the last reference
  constexpr int kInTurn = 2, kInTurnWithoutWords = 5;  // key frames tried in turn
  std::vector<KeyFrameId> places;
  const auto add = [&](KeyFrameId id) {
    if (map.at(id).submap != where.but && std::find(places.begin(), places.end(), id) == places.end())
      places.push_back(id);
  };
  if (words) {
    for (const auto& candidate : map.database().query(map, *words, {}, 0)) {
      if (places.size() < kAlike) add(candidate.key_frame);
    }
  }
  if (const auto resolved = map.resolve(where.near)) {
    add(resolved->key_frame);
    for (const Neighbour& n : map.best_neighbours(resolved->key_frame, kNeighbours)) add(n.key_frame);
  }
  const std::vector<KeyFrameId> all = map.key_frames();
  const int in_turn = words ? kInTurn : kInTurnWithoutWords;
  for (int k = 0; k < in_turn && !all.empty(); ++k) add(all[turn_++ % all.size()]);
  return places;
}

bool Relocaliser::find_first_pose(const KeyFrameView& view, TrackedFrame& frame, PoseSearch& search) const {
  if (FrameMatcher::match_key_frame(view, frame, kForRansac) < options_.first_pose.reference_min_matches) return false;
  if (!FrameMatcher::find_pose(frame, search.camera, seed_)) return false;
  return search.matcher.fit_pose(frame, search.local_map, search.camera) >= kMinInliers;
}

bool Relocaliser::find_at(const KeyFrameView& view, TrackedFrame& frame, PoseSearch& search, const SharedMap* live,
                          TrackFigures& figures) const {
  const LocalMapOptions& o = options_.local_map;
  if (!find_first_pose(view, frame, search)) return false;
  // The second search starts from a better pose, and so in narrower windows.
  constexpr double kWide = 5, kNarrow = 2;  // factors on the windows of tracking
  for (const double factor : {kWide, kNarrow}) {
    if (live) search.update_local_map(*live, frame, view.id, o.local_key_frames);
    const MatchGate gate =
        MatchGate::local_map(o.local_window * factor, o.local_window_frontal * factor, o.local_ratio);
    figures.local_in_view = search.matcher.match_local_map(search.local_map, frame, search.camera, gate);
    figures.local_points = search.local_map.size();
    figures.inliers = search.matcher.fit_pose(frame, search.local_map, search.camera);
    if (figures.inliers >= options_.recovery.min_inliers_recovered &&
        figures.inliers >= options_.recovery.min_recovered_share * figures.local_in_view) {
      figures.local_expected = search.look(frame);
      return search.place.is_right(search.found(frame, live), Arrival::relocalised);
    }
    if (figures.inliers < kMinInliers) return false;
  }
  return false;
}

}  // namespace covis
