// SPDX-License-Identifier: Apache-2.0
#include "covis/types.h"

#include <array>

namespace covis {
namespace {

struct ReasonText {
  NoPoseReason reason;
  const char* name;
  const char* words;
};

constexpr std::array kReasons = std::to_array<ReasonText>({
    {NoPoseReason::none, "none", ""},
    {NoPoseReason::waiting_for_first_view, "waiting_for_first_view", "waiting for a first view"},
    {NoPoseReason::few_features, "few_features", "too few features to begin a map"},
    {NoPoseReason::few_features_with_depth, "few_features_with_depth", "too few features with depth to begin a map"},
    {NoPoseReason::waiting_for_parallax, "waiting_for_parallax", "waiting for parallax"},
    {NoPoseReason::few_matches_with_first_view, "few_matches_with_first_view",
     "too few matches with the first view; starting from this one"},
    {NoPoseReason::few_matches_for_two_views, "few_matches_for_two_views", "too few matches for two-view geometry"},
    {NoPoseReason::no_motion_explains_matches, "no_motion_explains_matches",
     "neither a homography nor a fundamental matrix explains the matches"},
    {NoPoseReason::motion_ambiguous, "motion_ambiguous",
     "several motions explain the matches: move sideways to tell them apart"},
    {NoPoseReason::few_points_of_two_views, "few_points_of_two_views", "too few points can be triangulated"},
    {NoPoseReason::low_parallax, "low_parallax", "too little parallax: move sideways"},
    {NoPoseReason::initial_map_failed, "initial_map_failed", "the initial map did not hold"},
    {NoPoseReason::no_map_to_localise_in, "no_map_to_localise_in",
     "localisation only is set, and there is no map to localise in"},
    {NoPoseReason::few_matches_with_last_frame, "few_matches_with_last_frame", "too few matches with the last frame"},
    {NoPoseReason::few_agree_with_last_frame, "few_agree_with_last_frame",
     "too few matches with the last frame agree on a pose"},
    {NoPoseReason::no_reference_key_frame, "no_reference_key_frame", "no reference key frame"},
    {NoPoseReason::few_matches_with_key_frame, "few_matches_with_key_frame",
     "too few matches with the reference key frame"},
    {NoPoseReason::few_agree_with_key_frame, "few_agree_with_key_frame",
     "too few matches with the reference key frame agree on a pose"},
    {NoPoseReason::no_rotation_seen, "no_rotation_seen", "the images show no rotation"},
    {NoPoseReason::few_map_points_agree, "few_map_points_agree", "too few points of the map agree on a pose"},
    {NoPoseReason::little_of_view_explained, "little_of_view_explained", "the pose explains too little of the view"},
    {NoPoseReason::pose_uncertain, "pose_uncertain", "points of the map agree on a pose, but leave it uncertain"},
    {NoPoseReason::place_looks_different, "place_looks_different", "things match, but not what stands around them"},
    {NoPoseReason::no_key_frame_matches, "no_key_frame_matches", "lost: the view matches no key frame tried"},
});

const ReasonText& text_of(NoPoseReason reason) {
  for (const ReasonText& text : kReasons) {
    if (text.reason == reason) return text;
  }
  return kReasons.front();
}

}  // namespace

const char* name(TrackingState state) {
  switch (state) {
    case TrackingState::not_initialised:
      return "not_initialised";
    case TrackingState::tracking:
      return "tracking";
    case TrackingState::lost:
      return "lost";
  }
  return "";
}

const char* name(NoPoseReason reason) { return text_of(reason).name; }
const char* describe(NoPoseReason reason) { return text_of(reason).words; }

}  // namespace covis
