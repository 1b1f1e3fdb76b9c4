// SPDX-License-Identifier: Apache-2.0
// For tests: frames of a scene of bare points, as tracking sees them.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "covis/core/random.h"
#include "covis/map/test_point_scene.h"
#include "covis/tracking/tracked_frame.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {

// A frame of this view without matches, at a pose.
inline TrackedFrame frame_of(const PointScene::View& view, const SE3& T_cw, int64_t index = 0, Timestamp stamp = 0) {
  TrackedFrame frame;
  frame.start(view.features, index, stamp);
  frame.T_cw = T_cw;
  return frame;
}

// Matches every `every`-th feature that shows a point of the map with that point.
inline void match_points(TrackedFrame& frame, const PointScene::View& view, const SceneMap& world, size_t every = 1) {
  const auto map = world.shared.read();
  for (size_t f = 0; f < view.point.size(); f += every) {
    const MapPointId id = world.handles[view.point[f]];
    if (const MapPoint* point = map->find(id)) frame.set_match(f, id, point->position_w, PointSource::map);
  }
}

// The same features with something changed by edit(Features&).
template <class Edit>
PointScene::View edited(const PointScene::View& view, Edit&& edit) {
  auto features = std::make_shared<Features>(*view.features);
  edit(*features);
  return {features, view.point};
}

inline double distance(const SE3& a_cw, const SE3& b_cw) { return (a_cw.inverse().t() - b_cw.inverse().t()).norm(); }

// A vocabulary of one word for each point of the scene, by its index: as SceneMap gives them to key frames. The
// points get a quarter of their bits by groups, which tell them apart at the first level of the tree.
inline std::shared_ptr<const Vocabulary> number_points(PointScene& scene) {
  constexpr size_t kGroup = 200;
  Random random(9);
  std::vector<VocabularyNode> nodes;
  for (size_t p = 0; p < scene.points.size(); ++p) {
    if (p % kGroup == 0) {
      Descriptor group;
      group.bits[0] = random.next();
      nodes.push_back({group, 0, 0});
    }
    scene.points[p].descriptor.bits[0] = nodes.back().descriptor.bits[0];
  }
  const size_t groups = nodes.size();
  for (size_t p = 0; p < scene.points.size(); ++p)
    nodes.push_back({scene.points[p].descriptor, static_cast<uint32_t>(1 + p / kGroup), 1});
  EXPECT_EQ(groups, (scene.points.size() + kGroup - 1) / kGroup);
  return Vocabulary::build(static_cast<int>(kGroup), 2, nodes).value();
}

}  // namespace covis
