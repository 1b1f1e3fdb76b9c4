// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_report.h"

#include <algorithm>
#include <cstdio>

namespace covis {

const char* name(LoopRefusal refusal) {
  switch (refusal) {
    case LoopRefusal::none:
      return "none";
    case LoopRefusal::few_matches:
      return "few matches";
    case LoopRefusal::no_similarity:
      return "no similarity";
    case LoopRefusal::not_found_again:
      return "not found again";
    case LoopRefusal::small_share:
      return "small share found";
    case LoopRefusal::tied_already:
      return "tied already";
    case LoopRefusal::neighbours_disagree:
      return "neighbours disagree";
    case LoopRefusal::not_seen_from_there:
      return "not seen from there";
    case LoopRefusal::drift_too_great:
      return "drift too great";
    case LoopRefusal::unconfirmed:
      return "drift too great, unconfirmed";
  }
  return "";
}

void LoopEvidence::raise_to(const LoopEvidence& other) {
  matches = std::max(matches, other.matches);
  inliers = std::max(inliers, other.inliers);
  both_ways = std::max(both_ways, other.both_ways);
  found_again = std::max(found_again, other.found_again);
  in_view = std::max(in_view, other.in_view);
}

std::string describe(const RefusedPlace& refused) {
  char text[200];
  const LoopEvidence& e = refused.evidence;
  std::snprintf(text, sizeof text,
                "no loop to frame %lld: %s (%d matches, %d inliers, %d both ways, %d of %d points found again)",
                static_cast<long long>(refused.frame), name(refused.why), e.matches, e.inliers, e.both_ways,
                e.found_again, e.in_view);
  std::string all = text;
  if (refused.drift) {
    std::snprintf(text, sizeof text, ", correction %.3g of a path of %.3g (%.3g with turns), %.3g degrees, scale %.3g",
                  refused.drift->distance, refused.drift->path, refused.drift->past, refused.drift->rotation_deg,
                  refused.drift->scale);
    all += text;
  }
  if (refused.link) all += ", weakest link of " + std::to_string(*refused.link) + " points";
  return all;
}

}  // namespace covis
