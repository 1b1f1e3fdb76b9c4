// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>
#include <unordered_map>

#include "covis/features/straightening.h"
#include "covis/map/map.h"

namespace covis {
namespace {

std::string name(KeyFrameId id) { return "key frame " + std::to_string(id.slot) + "." + std::to_string(id.generation); }
std::string name(MapPointId id) { return "point " + std::to_string(id.slot) + "." + std::to_string(id.generation); }

template <class List, class Less>
bool strictly_sorted(const List& list, Less less) {
  return std::adjacent_find(list.begin(), list.end(), [&](const auto& a, const auto& b) { return !less(a, b); }) ==
         list.end();
}

std::string check_point(const Map& map, MapPointId id, const MapPoint& point) {
  if (!point.position_w.allFinite() || !point.normal_w.allFinite()) return name(id) + " is not finite";
  if (!(point.d_min >= 0 && point.d_min <= point.d_max)) return name(id) + " has no valid range of distances";
  if (point.observations.empty()) return name(id) + " has no observation";
  if (!strictly_sorted(point.observations,
                       [](const Observation& a, const Observation& b) { return a.key_frame < b.key_frame; })) {
    return name(id) + "'s observations are not sorted or not unique";
  }
  bool reference_observes = false;
  for (const Observation& o : point.observations) {
    const KeyFrame* key_frame = map.find(o.key_frame);
    if (!key_frame) return name(id) + " is observed by an erased " + name(o.key_frame);
    if (o.feature >= key_frame->points.size() || key_frame->points[o.feature] != id)
      return name(id) + " and " + name(o.key_frame) + " disagree on an observation";
    if (key_frame->submap != map.at(point.observations.front().key_frame).submap)
      return name(id) + " is seen from two submaps";
    reference_observes |= o.key_frame == point.reference;
  }
  if (!reference_observes) return name(id) + "'s reference does not observe it";
  return {};
}

// `weights`: a zero for each slot of key frames, and so again afterwards when nothing is wrong.
std::string check_key_frame(const Map& map, KeyFrameId id, const KeyFrame& key_frame, std::vector<int>& weights) {
  if (!key_frame.T_cw.all_finite()) return name(id) + " has a pose that is not finite";
  if (key_frame.points.size() != static_cast<size_t>(key_frame.features->size()))
    return name(id) + " has not a place for each feature";
  if (!straight_for(*key_frame.features, map.camera())) return name(id) + " has keypoints with another distortion";
  int64_t total = 0;
  for (size_t i = 0; i < key_frame.points.size(); ++i) {
    const MapPointId point_id = key_frame.points[i];
    if (!point_id.valid()) continue;
    const MapPoint* point = map.find(point_id);
    if (!point) return name(id) + " observes an erased " + name(point_id);
    bool mutual = false;
    for (const Observation& o : point->observations) {
      if (o.key_frame == id) {
        mutual = o.feature == i;
      } else if (o.key_frame.slot >= weights.size()) {
        return name(point_id) + " is observed by an erased " + name(o.key_frame);
      } else {
        ++weights[o.key_frame.slot];
        ++total;
      }
    }
    if (!mutual) return name(id) + " and " + name(point_id) + " disagree on an observation";
  }
  if (!strictly_sorted(key_frame.shared,
                       [](const Neighbour& a, const Neighbour& b) { return a.key_frame < b.key_frame; })) {
    return name(id) + "'s covisible key frames are not sorted or not unique";
  }
  for (const Neighbour& n : key_frame.shared) {
    if (!map.find(n.key_frame) || n.weight < 1 || n.weight != weights[n.key_frame.slot])
      return name(id) + " has a wrong covisibility weight";
    total -= n.weight;
    weights[n.key_frame.slot] = 0;
  }
  if (total != 0) return name(id) + " has a wrong number of covisible key frames";
  return {};
}

std::string check_links(const Map& map, KeyFrameId id, const KeyFrame& key_frame) {
  const auto less = [](KeyFrameId a, KeyFrameId b) { return a < b; };
  if (!strictly_sorted(key_frame.children, less) || !strictly_sorted(key_frame.loop_edges, less))
    return name(id) + " has unsorted links";
  for (const KeyFrameId& child : key_frame.children) {
    if (!map.find(child) || map.at(child).parent != id)
      return name(id) + " has a child that is erased or has another parent";
  }
  for (const KeyFrameId& other : key_frame.loop_edges) {
    if (!map.find(other)) return name(id) + " has a loop edge to an erased key frame";
    if (map.at(other).submap != key_frame.submap) return name(id) + " has a loop edge to another submap";
    const auto& back = map.at(other).loop_edges;
    if (!std::binary_search(back.begin(), back.end(), id)) return name(id) + " has a loop edge that is not mutual";
  }
  const Submap* submap = map.submap(key_frame.submap);
  if (!submap) return name(id) + " is of a submap that is not there";
  if (id == submap->root) return key_frame.parent.valid() ? name(id) + " is a root and has a parent" : "";
  if (!key_frame.parent.valid()) {
    // Just added and not attached yet: the newest only.
    return key_frame.serial + 1 == map.next_serial() && key_frame.children.empty() ? "" : name(id) + " has no parent";
  }
  const KeyFrame* parent = map.find(key_frame.parent);
  if (!parent || !std::binary_search(parent->children.begin(), parent->children.end(), id))
    return name(id) + "'s parent is erased or does not know it";
  return {};
}

// Down the tree of every submap: whoever is not met is connected to no root. check_links() has seen that parents and
// children agree, so that each is met once at most and the walk ends.
std::string check_trees(const Map& map, size_t slots) {
  std::vector<bool> met(slots);
  std::vector<KeyFrameId> open;
  for (const Submap& submap : map.submaps()) {
    open.assign(1, submap.root);
    while (!open.empty()) {
      const KeyFrameId id = open.back();
      const KeyFrame* key_frame = map.find(id);
      open.pop_back();
      if (!key_frame || met[id.slot] || key_frame->submap != submap.id)
        return name(id) + " is not where the spanning tree of a submap has it";
      met[id.slot] = true;
      open.insert(open.end(), key_frame->children.begin(), key_frame->children.end());
    }
  }
  std::string problem;
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    if (!met[id.slot] && key_frame.parent.valid() && problem.empty())
      problem = name(id) + " is not connected to its submap's root";
  });
  return problem;
}

// Every key frame with words stands under each of them, and nothing else stands there.
std::string check_database(const Map& map) {
  const KeyFrameDatabase& database = map.database();
  size_t wanted = 0, there = 0;
  std::string problem;
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    if (!key_frame.words) return;
    wanted += key_frame.words->words.size();
    for (const WordWeight& w : key_frame.words->words) {
      const auto& holders = database.holders(w.word);
      if (!std::binary_search(holders.begin(), holders.end(), id.slot) && problem.empty()) {
        problem = name(id) + " is not in the database";
      }
    }
  });
  for (uint32_t word = 0; word < database.words(); ++word) there += database.holders(word).size();
  if (problem.empty() && wanted != there) problem = "the database holds an erased key frame";
  return problem;
}

std::string check_submaps(const Map& map) {
  size_t total = 0;
  std::unordered_map<uint32_t, size_t> key_frames;  // by the submap's id
  map.for_each_key_frame([&](KeyFrameId, const KeyFrame& k) { ++key_frames[k.submap]; });
  for (const Submap& submap : map.submaps()) {
    const KeyFrame* root = map.find(submap.root);
    if (!root || root->submap != submap.id) return "the root of submap " + std::to_string(submap.id) + " is erased";
    if (key_frames[submap.id] != submap.key_frames) return "submap " + std::to_string(submap.id) + " has a wrong count";
    total += submap.key_frames;
  }
  if (total != map.key_frame_count()) return "a key frame belongs to no submap";
  return strictly_sorted(map.submaps(), [](const Submap& a, const Submap& b) { return a.id < b.id; })
             ? ""
             : "the submaps are not sorted";
}

}  // namespace

std::string Map::check() const {
  std::string problem;
  std::set<uint32_t> serials;
  std::vector<int> weights;
  for_each_key_frame([&](KeyFrameId id, const KeyFrame&) { weights.resize(id.slot + size_t{1}); });
  for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    if (!serials.insert(key_frame.serial).second && problem.empty()) problem = name(id) + " has a serial used twice";
    if (problem.empty()) problem = check_key_frame(*this, id, key_frame, weights);
    if (problem.empty()) problem = check_links(*this, id, key_frame);
  });
  for_each_point([&](MapPointId id, const MapPoint& point) {
    if (problem.empty()) problem = check_point(*this, id, point);
  });
  if (problem.empty()) problem = check_submaps(*this);
  if (problem.empty()) problem = check_trees(*this, weights.size());
  if (problem.empty()) problem = check_database(*this);
  return problem;
}

}  // namespace covis
