// SPDX-License-Identifier: Apache-2.0
#include "synth/render/loop_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "covis/core/random.h"

namespace covis::synth {
namespace {

using std::numbers::pi;

struct Loop {
  LoopOptions o;
  double straight_x, straight_y, arc, total;

  explicit Loop(const LoopOptions& options)
      : o(options),
        straight_x(o.length - 2 * o.corner),
        straight_y(o.width - 2 * o.corner),
        arc(0.5 * pi * o.corner),
        total(2 * straight_x + 2 * straight_y + 4 * arc) {}

  // Gives position and direction at s metres from the middle of the side at -y, going +x, and the signed distance to
  // the nearest corner: negative inside a corner.
  void at(double s, Eigen::Vector2d& position, double& heading, double& to_corner) const {
    s = std::fmod(s, total);
    double rest = s + 0.5 * straight_x;  // distance from the start of the current side's straight
    Eigen::Vector2d p(-0.5 * straight_x, -0.5 * o.width), forward(1, 0);
    heading = 0;
    for (int side = 0; side < 5; ++side) {
      const double straight = side % 2 ? straight_y : straight_x;
      if (rest <= straight) {
        position = p + rest * forward;
        to_corner = std::min(rest, straight - rest);
        return;
      }
      rest -= straight;
      p += straight * forward;
      const Eigen::Vector2d left(-forward.y(), forward.x());
      if (rest <= arc) {
        const double a = rest / o.corner;
        position = p + o.corner * (std::sin(a) * forward + (1 - std::cos(a)) * left);
        heading += a;
        to_corner = -std::min(rest, arc - rest);
        return;
      }
      rest -= arc;
      p += o.corner * (forward + left);
      forward = left;
      heading += 0.5 * pi;
    }
    position = p;
    to_corner = 0;
  }

  double speed(double s) const {
    Eigen::Vector2d position;
    double heading, to_corner;
    at(s, position, heading, to_corner);
    const double t = std::clamp(to_corner / o.easing, 0.0, 1.0);
    return o.slow + (o.fast - o.slow) * t * t * (3 - 2 * t);
  }
};

}  // namespace

CameraPath make_loop(const LoopOptions& options, uint64_t seed) {
  const Loop loop(options);
  Random random(seed);
  // Integrates the time along the path, then samples positions at equally spaced times.
  const double step = 0.01, wanted_interval = 0.4;
  const int steps = static_cast<int>(loop.total / step);
  std::vector<double> time(1, 0.0);
  for (int i = 0; i < steps; ++i) {
    time.push_back(time.back() + loop.total / steps / loop.speed(loop.total * (i + 0.5) / steps + options.start));
  }
  const int count = static_cast<int>(time.back() / wanted_interval);
  const double interval = time.back() / count;
  const double p1 = random.uniform(0, 2 * pi), p2 = random.uniform(0, 2 * pi), p3 = random.uniform(0, 2 * pi);
  std::vector<CameraPose> control;
  for (int i = 0; i < count; ++i) {
    const auto after = std::upper_bound(time.begin(), time.end(), i * interval);
    const size_t k = static_cast<size_t>(after - time.begin()) - 1;
    const double fraction = k + 1 < time.size() ? (i * interval - time[k]) / (time[k + 1] - time[k]) : 0;
    const double s = options.start + loop.total * (static_cast<double>(k) + fraction) / steps;
    Eigen::Vector2d position;
    double heading, to_corner;
    loop.at(s, position, heading, to_corner);
    const double turn = 2 * pi * s / loop.total;
    const Eigen::Vector2d left(-std::sin(heading), std::cos(heading));
    position += options.weave * std::sin(5 * turn + p1) * left;
    CameraPose pose;
    pose.position = {position.x(), position.y(), options.height};
    // The heading accumulates over the whole journey: it keeps growing past the starting line of the loop.
    pose.heading = heading + (s >= loop.total ? 2 * pi : 0) + options.glance * std::sin(7 * turn + p2);
    pose.pitch = options.pitch + 0.3 * options.glance * std::sin(9 * turn + p3);
    control.push_back(pose);
  }
  return {std::move(control), interval, 1, options.sway, random.next()};
}

}  // namespace covis::synth
