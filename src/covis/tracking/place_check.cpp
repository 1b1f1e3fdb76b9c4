// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/place_check.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "covis/matching/expected_matches.h"

namespace covis {
namespace {

constexpr double kTentativeTime = 1.0;  // seconds

}  // namespace

bool PlaceCheck::is_right(const Found& found, Arrival arrival) {
  // In real time the same frame is judged once more where the map has moved meanwhile.
  if (jump_ && jump_->frame == found.frame.index) jump_.reset();
  const bool jump = jumped(found, arrival);
  const Demand demand = jump || tentative() ? Demand::strict : Demand::usual;
  const Witness witness = !jump                             ? Witness::for_it
                          : arrival == Arrival::relocalised ? Witness::both
                                                            : Witness::against_it;
  if (found.live && !looks_as_expected(found, demand, witness)) return false;
  // Back where it was: the tentative place in another submap was a wrong one.
  if (!jump && last_ && last_->submap != found.local_map.reference.submap) take_back_jump();
  if (jump && (arrival != Arrival::tracked || tentative() || !found.live)) {
    take_back_jump();
    jump_ = {found.frame.index, found.frame.stamp};
  }
  return true;
}

bool PlaceCheck::is_shown(const Found& found) const {
  if (!found.live) return false;
  std::optional<ShownPoints> shown;
  {
    const auto map = found.live->read();
    shown = points_to_show(found, *map);
  }
  const auto share = shown ? shown->even_share(*found.image) : std::nullopt;
  return share && *share >= options_.min_shown_share;
}

void PlaceCheck::doubt(const TrackedFrame& frame) { jump_ = {jump_ ? jump_->frame : frame.index, frame.stamp}; }

void PlaceCheck::accept(const TrackedFrame& frame, uint32_t submap) {
  if (jump_ && frame.stamp - jump_->stamp >= from_seconds(kTentativeTime)) jump_.reset();
  Place place{frame.T_cw, submap, frame.stamp};
  const bool moved_here = last_ && last_->submap == submap && tentative_since() != frame.stamp;
  if (moved_here && frame.stamp > last_->stamp) {
    const bool burst = usual_.is_burst(frame.stamp - last_->stamp);
    Eigen::Vector3d way = frame.T_cw.centre() - last_->T_cw.centre();
    place.interval = frame.stamp - last_->stamp;
    if (burst && last_->interval > 0) {
      way += to_seconds(last_->interval) * (last_->T_cw.R().transpose() * last_->velocity);
      place.interval += last_->interval;
    } else if (burst) {
      place.interval = 0;
    }
    if (place.interval > 0) place.velocity = frame.T_cw.R() * way / to_seconds(place.interval);
  }
  last_ = place;
  if (!tentative()) settle(place);
}

void PlaceCheck::settle(const Place& place) {
  std::erase_if(settled_,
                [&](const Place& other) { return other.submap == place.submap || is_long_ago(other, place.stamp); });
  settled_.push_back(place);
}

bool PlaceCheck::is_long_ago(const Place& place, Timestamp now) {
  constexpr double kComesBack = 5;  // seconds
  return now - place.stamp > from_seconds(kComesBack);
}

void PlaceCheck::lose() {
  if (jump_) last_.reset();  // a wrong place is none to have come from
  take_back_jump();
}

void PlaceCheck::restart() {
  last_.reset();
  settled_.clear();
  jump_.reset();
}

void PlaceCheck::follow(const SE3& T_cw, uint32_t submap, double growth) {
  if (!last_) return;
  last_->velocity *= growth;
  last_->T_cw = T_cw;
  last_->submap = submap;
}

std::optional<int64_t> PlaceCheck::take_retraction() { return std::exchange(retract_from_, std::nullopt); }

void PlaceCheck::take_back_jump() {
  if (!jump_) return;
  retract_from_ = std::min(jump_->frame, retract_from_.value_or(jump_->frame));
  jump_.reset();
}

// A camera that was at a wrong place, or in a map begun in between, comes back to where it was before.
const PlaceCheck::Place* PlaceCheck::came_from(uint32_t submap, Timestamp now) const {
  if (last_ && last_->submap == submap) return &*last_;
  for (const Place& place : settled_) {
    if (place.submap == submap && !is_long_ago(place, now)) return &place;
  }
  return nullptr;
}

// True when the camera is too far from its last place to have just moved there. With few frames a second it goes
// farther in one. A camera that was lost for a moment moved on meanwhile: about as fast as before, and it may have
// turned with every frame. Things that the last frame saw too show how far it turned in one.
bool PlaceCheck::jumped(const Found& found, Arrival arrival) const {
  constexpr double kTurn = std::numbers::pi / 12, kMostTurn = std::numbers::pi / 3;  // a frame, and in all
  constexpr double kWay = 0.2, kMostWay = 0.5;  // share of the mean depth, a frame and at most
  constexpr double kQuickFrame = 0.1;           // seconds
  constexpr double kSlack = 0.5;                // share of the way gone while lost
  constexpr double kMoment = 0.5;  // seconds; where a camera lost for longer is found says nothing of how it went there
  const Place* from = came_from(found.local_map.reference.submap, found.frame.stamp);
  if (!from) return true;
  const SE3 T_cl = found.frame.T_cw * from->T_cw.inverse();
  const Timestamp elapsed = found.frame.stamp - from->stamp;
  double lost = from->interval > 0 ? to_seconds(elapsed - from->interval) : 0;  // seconds
  if (lost < 0 || lost > kMoment) lost = 0;
  const Eigen::Vector3d on_the_way = lost * (from->T_cw.R().transpose() * from->velocity);
  const Eigen::Vector3d off = found.frame.T_cw.centre() - from->T_cw.centre() - on_the_way;
  const double frames = lost > 0 ? 1 + lost / to_seconds(from->interval) : 1;
  const bool steady = from->interval > 0 || arrival == Arrival::relocalised;  // else the interval is this one
  const Timestamp step = steady ? std::min(elapsed, from->interval) : elapsed;
  const double slow = std::max(1.0, to_seconds(step) / kQuickFrame);
  const double turn = arrival == Arrival::recognised ? kMostTurn : std::min(kTurn * slow * frames, kMostTurn);
  const double way = std::min(kWay * slow, kMostWay);
  return off.norm() > way * found.frame.mean_depth() + kSlack * on_the_way.norm() ||
         (T_cl.R().trace() - 1) / 2 < std::cos(turn);
}

// Holds a read guard for as long as it goes through the points in view and their observers, some thousands of plain
// numbers: copying these would take as long.
//
// In another light fewer points match than usual, but what is around them still looks alike. A camera that jumped, and
// a single image, have to show something alike also where enough match: points side by side match by a pose of which
// nothing else is true, and so does half of a look-alike (docs/notes/024-places-in-another-light.md).
bool PlaceCheck::looks_as_expected(const Found& found, Demand demand, Witness image) {
  if (options_.min_expected_match_ratio == 0) return true;
  Matches matches;
  std::optional<ShownPoints> shown;
  {
    const auto map = found.live->read();
    matches = matches_as_expected(found, *map, demand);
    const bool decided = image == (matches.enough ? Witness::for_it : Witness::against_it);
    if (!decided) shown = points_to_show(found, *map);
  }
  const auto share = shown ? shown->even_share(*found.image) : std::nullopt;
  return share ? *share >= std::min(matches.least_shown, options_.min_shown_share) : matches.enough;
}

// Compares the points in view that were seen from about here before with how often they usually match. Points seen from
// here decide: 0.6 of what is expected is exceeded by some 98 % of right places and 3 % of wrong ones. Where they are
// too few, those seen from the same side say less, and must not speak against the place. More is asked of a single
// image, which no later ones confirm.
PlaceCheck::Matches PlaceCheck::matches_as_expected(const Found& found, const Map& map, Demand demand) {
  const bool strict = demand == Demand::strict;
  constexpr double kUsualFactor = 0.5;                              // on the share asked for where there was no jump
  constexpr double kNearFactor = 0.25, kNearFactorSingle = 0.5;     // on it for points seen from the same side
  constexpr double kYoungFactor = 0.17, kYoungFactorSingle = 0.25;  // the same with points not known well yet
  const double asked = options_.min_expected_match_ratio;
  const double share = (strict ? 1 : kUsualFactor) * asked;
  const double shown = asked / 0.6 * 0.4;  // share that matches times the one shown
  const Matches few{false, 1}, near_enough{true, asked / 0.6 * 0.36};
  const bool single = subject_ == Subject::single_image;
  const Eigen::Vector3d centre_w = found.frame.T_cw.centre();
  found.frame.map_points(matched_);
  std::sort(matched_.begin(), matched_.end());
  ExpectedMatches expected;
  const std::vector<MapPointId>& points = found.local_map.points.id;
  for (size_t k = 0; k < points.size(); ++k) {
    const MapPoint* point = found.in_view[k] ? map.find(points[k]) : nullptr;
    if (point) expected.add(*point, map, centre_w, std::binary_search(matched_.begin(), matched_.end(), points[k]));
  }
  const MatchTally &here = expected.from_here, &near = expected.from_near, &young_too = expected.young_too;
  if (here.enough())
    return here.reaches(share) ? Matches{true, shown / std::min(1.0, here.found / here.expected)} : few;
  if (near.enough() && !near.reaches((single ? kNearFactorSingle : kNearFactor) * share)) return few;
  if (young_too.enough())
    return young_too.reaches((single ? kYoungFactorSingle : kYoungFactor) * share) ? near_enough : few;
  return strict ? few : near_enough;  // no point was seen from here before
}

std::optional<ShownPoints> PlaceCheck::points_to_show(const Found& found, const Map& map) const {
  if (!found.image || options_.min_shown_share >= 1) return std::nullopt;
  // The pose is that of features without the turn between rows; the image has it still.
  if (!found.frame.features->exposure.taken().isZero()) return std::nullopt;
  std::optional<ShownPoints> shown(std::in_place, map.camera(), found.frame.T_cw, found.frame.features->grid.bounds);
  const std::vector<MapPointId>& points = found.local_map.points.id;
  for (size_t k = 0; k < points.size(); ++k) {
    if (const MapPoint* point = found.in_view[k] ? map.find(points[k]) : nullptr) shown->add(*point, map);
  }
  return shown;
}

bool well_determined(const Matrix6d& information, double mean_depth, const Pinhole& camera) {
  constexpr double kSigma = 2;  // pixels
  const Matrix6d covariance = information.inverse();
  return camera.fx * std::sqrt(covariance.topLeftCorner<3, 3>().trace()) <= kSigma * mean_depth;
}

}  // namespace covis
