// SPDX-License-Identifier: Apache-2.0
// The worlds: what is in them, and that images, depth and poses agree.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "covis/features/extractor.h"
#include "covis/synth/renderer.h"
#include "covis/synth/scene.h"
#include "covis/synth/test_worlds.h"
#include "covis/synth/world.h"

namespace covis {
namespace {

// The worlds made to fool: what looks alike is not the same place.
bool is_open(const std::string& name) { return name == "twins" || name == "posters"; }

class EveryWorld : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Worlds, EveryWorld, testing::ValuesIn(synth_worlds()),
                         [](const auto& param_info) { return param_info.param; });

TEST_P(EveryWorld, SameSeedSameBytesInAnyOrder) {
  SynthOptions options = small(GetParam());
  options.noise = 3;
  options.exposure = 0.2;
  options.blur = 10;
  options.depth_noise = 1;
  options.distortion = 0.7;
  Synth a = make(options), b = make(options);
  ImageU8 first, second, other, plain1, plain2;
  ImageF depth1, depth2;
  a.render(3, first, nullptr, &depth1);
  b.render(200, other, nullptr, nullptr);
  b.render(3, second, nullptr, &depth2);
  world(GetParam(), 1).render(3, plain1, nullptr, nullptr);
  world(GetParam(), 2).render(3, plain2, nullptr, nullptr);
  EXPECT_EQ(hash(first), hash(second));
  EXPECT_NE(hash(first), hash(other));
  EXPECT_NE(hash(plain1), hash(plain2));
  for (int y = 0; y < depth1.height(); ++y) {
    ASSERT_TRUE(std::equal(depth1.row(y), depth1.row(y) + depth1.width(), depth2.row(y))) << y;
  }
}

TEST(Synth, EverySimdTargetGivesTheSameBytes) {
  Synth& synth = world("street");
  ImageU8 image;
  ImageF depth;
  std::vector<uint64_t> hashes;
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    synth.render(11, image, nullptr, &depth);
    hashes.push_back(hash(image));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  EXPECT_GE(hashes.size(), 1u);
  EXPECT_THAT(hashes, testing::Each(hashes[0]));
}

// What one frame sees, moved by the truth, is what the next frames see.
TEST_P(EveryWorld, DepthAndPosesExplainTheNextImage) {
  Synth& synth = world(GetParam());
  ImageU8 image1, image2;
  ImageF depth1, depth2;
  const Camera& camera = synth.camera();
  for (const int i : {0, 100, 250}) {
    const int step = GetParam() == "street" ? 1 : 4;
    synth.render(i, image1, nullptr, &depth1);
    synth.render(i + step, image2, nullptr, &depth2);
    const SE3 T_21 = synth.T_wc(i + step).inverse() * synth.T_wc(i);
    std::vector<double> tone_errors, depth_errors;
    for (int y = 0; y < camera.height; y += 2) {
      for (int x = 0; x < camera.width; x += 2) {
        if (!(depth1(x, y) > 0)) continue;
        const Eigen::Vector3d p = T_21 * (static_cast<double>(depth1(x, y)) * camera.pinhole.unproject(x, y));
        if (p.z() <= 0.05) continue;
        const Eigen::Vector2d at = camera.pinhole.project(p);
        if (!inside(camera, at)) continue;
        depth_errors.push_back(std::abs(sample(depth2, at.x(), at.y()) - p.z()) / p.z());
        tone_errors.push_back(std::abs(sample(image2, at.x(), at.y()) - image1(x, y)));
      }
    }
    ASSERT_GT(tone_errors.size(), 3000u);
    EXPECT_LT(quantile(depth_errors, 0.5), 1e-3) << i;
    EXPECT_LT(quantile(depth_errors, 0.8), 0.01) << i;
    EXPECT_LT(quantile(tone_errors, 0.5), 5) << i;
  }
}

TEST_P(EveryWorld, DisparityIsBaselineTimesFocalOverDepth) {
  Synth& synth = world(GetParam());
  ImageU8 left, right;
  ImageF depth;
  synth.render(50, left, &right, &depth);
  const Camera& camera = synth.camera();
  const double bf = camera.pinhole.fx * synth.options().baseline;
  // The right image is explained best by exactly this disparity.
  std::vector<double> errors;
  for (const double shift : {-0.3, 0.0, 0.3}) {
    double sum = 0;
    int count = 0;
    for (int y = 1; y < camera.height - 1; ++y) {
      for (int x = 1; x < camera.width - 1; ++x) {
        if (!(depth(x, y) > 0)) continue;
        const double u = x - bf / static_cast<double>(depth(x, y)) + shift;
        if (u < 1 || u > camera.width - 2) continue;
        sum += std::min(30.0, std::abs(sample(right, u, y) - left(x, y)));
        ++count;
      }
    }
    errors.push_back(sum / count);
  }
  EXPECT_LT(errors[1], 0.8 * errors[0]);
  EXPECT_LT(errors[1], 0.8 * errors[2]);
  EXPECT_LT(errors[1], 6);
}

TEST_P(EveryWorld, MovesSmoothlyAtASensibleSpeed) {
  for (const int seed : {1, 2}) {
    const Synth& synth = world(GetParam(), seed);
    const double fps = synth.options().fps;
    const bool street = GetParam() == "street";
    const double top_speed = street                     ? 10.5
                             : GetParam() == "corridor" ? 1.8
                             : is_open(GetParam())      ? 1.2
                                                        : 1.0,
                 top_turn = (street ? 40 : 50) * std::numbers::pi / 180;
    Eigen::Vector3d last_velocity(0, 0, 0), last_turn(0, 0, 0);
    double mean_speed = 0;
    for (int i = 0; i + 1 < synth.frames(); ++i) {
      const SE3 a = synth.T_wc(i), b = synth.T_wc(i + 1);
      const Eigen::Vector3d velocity = fps * (b.t() - a.t());
      const Eigen::AngleAxisd angle(a.R().transpose() * b.R());
      const Eigen::Vector3d turn = fps * angle.angle() * angle.axis();
      EXPECT_TRUE((a.R() * a.R().transpose()).isIdentity(1e-9) && a.R().determinant() > 0);
      ASSERT_LT(velocity.norm(), top_speed) << i;
      ASSERT_LT(turn.norm(), top_turn) << i;
      if (i > 0) {  // nothing jumps
        ASSERT_LT(fps * (velocity - last_velocity).norm(), street ? 8 : 3) << i;
        ASSERT_LT(fps * (turn - last_turn).norm(), 3) << i;
      }
      if (i == 0) {
        EXPECT_GT(velocity.norm(), 0.1) << "a monocular start needs parallax";
      }
      last_velocity = velocity;
      last_turn = turn;
      mean_speed += velocity.norm() / (synth.frames() - 1);
    }
    EXPECT_GT(mean_speed, street ? 6 : GetParam() == "corridor" ? 0.9 : 0.25);
  }
}

TEST_P(EveryWorld, ComesBackToItsBeginningOrNeverWill) {
  const Synth& synth = world(GetParam());
  const SE3 start = synth.T_wc(0);
  if (is_open(GetParam())) {
    double length = 0;
    for (int i = 0; i + 30 < synth.frames(); i += 30) {
      const Eigen::Vector3d a = synth.T_wc(i).t(), b = synth.T_wc(i + 30).t();
      EXPECT_GT(b.x(), a.x() + 0.3) << "going on in every second, here after frame " << i;
      length += (b - a).norm();
    }
    EXPECT_GT(length, 14);
    EXPECT_LT(length, 40);
    EXPECT_GE(synth.frames(), 400);
    EXPECT_LE(synth.frames(), 960);
    return;
  }
  double nearest = 1e9, farthest = 0;
  for (int i = 0; i < synth.frames(); ++i) {
    const SE3 pose = synth.T_wc(i);
    farthest = std::max(farthest, (pose.t() - start.t()).norm());
    const double turned = Eigen::AngleAxisd(pose.R().transpose() * start.R()).angle();
    if (i > synth.frames() * 3 / 4) nearest = std::min(nearest, (pose.t() - start.t()).norm() + turned);
  }
  EXPECT_LT(nearest, GetParam() == "street" ? 1.2 : 0.25);
  const double least_extent = GetParam() == "street"     ? 60
                              : GetParam() == "corridor" ? 15
                              : GetParam() == "room"     ? 2
                                                         : 0.5;
  EXPECT_GT(farthest, least_extent);
}

TEST_P(EveryWorld, IsClosedAndNotFlat) {
  for (const int seed : {1, 2}) {
    Synth& synth = world(GetParam(), seed);
    ImageU8 image;
    ImageF depth;
    for (int k = 0; k < 8; ++k) {
      const int i = k * synth.frames() / 8;
      synth.render(i, image, nullptr, &depth);
      int empty = 0;
      std::vector<double> depths, tones;
      for (int y = 0; y < depth.height(); ++y) {
        for (int x = 0; x < depth.width(); ++x) {
          empty += depth(x, y) <= 0;
          if (depth(x, y) > 0) depths.push_back(static_cast<double>(depth(x, y)));
          tones.push_back(image(x, y));
        }
      }
      if (GetParam() == "street") {
        EXPECT_LT(empty, depth.width() * depth.height() / 2) << "sky in frame " << i;
      } else {
        EXPECT_EQ(empty, 0) << "frame " << i;
      }
      EXPECT_GT(quantile(depths, 0.9) / quantile(depths, 0.1), 1.1) << "frame " << i;
      EXPECT_GT(quantile(tones, 0.9) - quantile(tones, 0.1), 30) << "frame " << i;
      EXPECT_GT(quantile(depths, 0), 0.15) << "the camera is inside something in frame " << i;
    }
  }
}

TEST(Synth, OpenPathsEndAtRestInsideTheirWorld) {
  for (const char* name : {"twins", "posters"}) {
    SynthOptions options = small(name);
    Synth& plain = world(name);
    options.frames = 2 * plain.frames();
    Synth longer = make(options);
    EXPECT_LT((longer.T_wc(2 * plain.frames() - 1).t() - longer.T_wc(plain.frames()).t()).norm(), 0.5) << name;
    ImageU8 image;
    ImageF depth;
    longer.render(2 * plain.frames() - 1, image, nullptr, &depth);
    for (int y = 0; y < depth.height(); ++y) {
      ASSERT_GT(*std::min_element(depth.row(y), depth.row(y) + depth.width()), 0.15f) << name;
    }
  }
}

TEST(Synth, TheTwinRoomsAreEqualAndThePassageIsNot) {
  const Camera& camera = world("twins").camera();
  synth::Renderer renderer = synth::Renderer::create(camera).value();
  for (const uint64_t seed : {1u, 2u}) {
    const synth::World twins = synth::make_twins(seed);
    const auto& polygons = twins.scene.polygons;
    // The first polygon is a wall of the first room; its texture comes once more, in the second.
    const auto twin = std::find_if(polygons.begin() + 1, polygons.end(),
                                   [&](const auto& p) { return p.texture == polygons[0].texture; });
    ASSERT_NE(twin, polygons.end());
    const Eigen::Vector3d spacing = twin->centre - polygons[0].centre;
    EXPECT_GT(spacing.x(), 9);
    EXPECT_NEAR(spacing.y(), 0, 1e-12);
    EXPECT_NEAR(spacing.z(), 0, 1e-12);
    // Two views of equal places: how often tone and depth are the same.
    const auto same = [&](const Eigen::Vector3d& position, double heading) {
      ImageF tone[2], depth[2];
      for (const int i : {0, 1}) {
        const synth::CameraPose pose{position + i * spacing, heading};
        renderer.render(twins.scene, pose.T_wc(), tone[i], depth[i]);
      }
      int equal = 0;
      for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
          equal += std::abs(tone[0](x, y) - tone[1](x, y)) < 1 && std::abs(depth[0](x, y) - depth[1](x, y)) < 1e-3f;
        }
      }
      return static_cast<double>(equal) / (camera.width * camera.height);
    };
    const Eigen::Vector3d inside(3, 2.8, 1.4);
    EXPECT_GT(same(inside, 1.6), 0.999) << "to one side, away from the openings";
    EXPECT_GT(same(inside, -1.6), 0.999) << "to the other";
    EXPECT_GT(same(inside, 0), 0.6) << "ahead, where the passages differ";
    EXPECT_LT(same(inside, 0), 0.999);
    EXPECT_LT(same(inside + 0.7 * spacing, 0), 0.2) << "from the passage and from behind all things";
    // Both are walked alike.
    const auto pose_at = [&](double x) {
      double seconds = 0;
      while (seconds < twins.path.period() && twins.path.at(seconds).position.x() < x) seconds += 0.01;
      return twins.path.at(seconds);
    };
    for (const double x : {1.0, 3.0, 5.0}) {
      const synth::CameraPose first = pose_at(x), second = pose_at(x + spacing.x());
      EXPECT_LT((first.position + spacing - second.position).norm(), 0.12) << x;
      EXPECT_NEAR(first.heading, second.heading, 0.12) << x;
      EXPECT_NEAR(first.pitch, second.pitch, 0.12) << x;
    }
  }
}

TEST(Synth, TheHallRepeatsItsPostersInOtherPlaces) {
  for (const uint64_t seed : {1u, 2u}) {
    const synth::World hall = synth::make_posters(seed);
    std::map<int, std::vector<Eigen::Vector3d>> places;
    for (const auto& p : hall.scene.polygons) {
      if (std::abs(p.normal.z()) < 0.1 && p.centre.z() > 0.9 && p.centre.z() < 1.8) {
        places[p.texture].push_back(p.centre);
      }
    }
    int repeated = 0;
    for (const auto& [texture, centres] : places) repeated += centres.size() >= 4;
    EXPECT_GE(repeated, 6) << "three posters, two doors and a board";
  }
}

TEST(Scene, APiecePutElsewhereLooksTheSame) {
  const auto make_scene = [] {
    synth::Scene scene(5);
    synth::Canvas canvas(1, 1, 100, 120);
    canvas.fractal(0.3, 60, 4, 0.8, 3);
    synth::Skin skin{.texture = scene.add_texture(canvas), .metres = 1, .detail = 0.1};
    synth::add_box(scene, {{3, 0.2, 0}, 0.3}, 0.5, 0.7, 0.9, synth::BoxSkin(skin));
    return scene;
  };
  const synth::Scene plain = make_scene();
  synth::Scene moved = make_scene();
  const synth::Piece piece = moved.cut(2);
  EXPECT_EQ(moved.polygons.size(), 2u);
  EXPECT_EQ(piece.polygons.size() + 2, plain.polygons.size());
  const synth::Place place{{4, -3, 0.5}, 1.1};
  moved.put(piece, place);
  ASSERT_EQ(moved.polygons.size(), plain.polygons.size());
  for (size_t k = 2; k < plain.polygons.size(); ++k) {
    const synth::Polygon &p = plain.polygons[k], &q = moved.polygons[k];
    ASSERT_EQ(p.count, q.count);
    EXPECT_EQ(p.gain, q.gain);
    EXPECT_EQ(p.radius, q.radius);
    for (int i = 0; i < p.count; ++i) {
      const Eigen::Vector3d& a = plain.vertices[static_cast<size_t>(p.first + i)];
      const Eigen::Vector3d& b = moved.vertices[static_cast<size_t>(q.first + i)];
      EXPECT_TRUE(b.isApprox(place(a.x(), a.y(), a.z()), 1e-12));
      EXPECT_NEAR(q.normal.dot(b), q.offset, 1e-12);
      EXPECT_NEAR(p.u_w.dot(a) + p.u_0, q.u_w.dot(b) + q.u_0, 1e-12);
      EXPECT_NEAR(p.v_w.dot(a) + p.v_0, q.v_w.dot(b) + q.v_0, 1e-12);
    }
    EXPECT_TRUE(q.centre.isApprox(place(p.centre.x(), p.centre.y(), p.centre.z()), 1e-12));
  }
}

// What a tracker lives on: as many key points as it asks for, spread over the image, and found again in the next frames
// where the truth says.
TEST_P(EveryWorld, GivesKeyPointsThatAreFoundAgain) {
  SynthOptions options = small(GetParam());
  options.width = 640;
  options.height = 480;
  Synth synth = make(options);
  OrbOptions orb;
  orb.features = 1000;
  OrbExtractor extractor1(orb), extractor2(orb);
  const Camera& camera = synth.camera();
  const int step = GetParam() == "street" ? 1 : 3;
  ImageU8 image1, image2;
  ImageF depth1;
  int total = 0, found = 0, expected = 0;
  std::vector<double> errors;
  for (const int i : {10, 130, 250, 370}) {
    synth.render(i, image1, nullptr, &depth1);
    synth.render(i + step, image2, nullptr, nullptr);
    const SE3 T_21 = synth.T_wc(i + step).inverse() * synth.T_wc(i);
    const KeyPoints& a = extractor1.extract(image1.view());
    const KeyPoints& b = extractor2.extract(image2.view());
    EXPECT_GE(a.size(), 950u) << i;
    std::vector<int> cells(8 * 6, 0);
    for (size_t k = 0; k < a.size(); ++k) {
      ++cells[static_cast<size_t>(a.y[k] / 80) * 8 + static_cast<size_t>(a.x[k] / 80)];
      const float z = depth1(static_cast<int>(std::lround(a.x[k])), static_cast<int>(std::lround(a.y[k])));
      ++total;
      if (!(z > 0)) continue;
      const Eigen::Vector3d p = T_21 * (static_cast<double>(z) * camera.pinhole.unproject(a.x[k], a.y[k]));
      if (p.z() < 0.1) continue;
      const Eigen::Vector2d at = camera.pinhole.project(p);
      if (at.x() < 25 || at.y() < 25 || at.x() > camera.width - 25 || at.y() > camera.height - 25) continue;
      ++expected;
      const double scale = std::pow(1.2, a.level[k]);
      int best = 60;
      double error = 0;
      for (size_t m = 0; m < b.size(); ++m) {
        const double dx = (b.x[m] - at.x()) / scale, dy = (b.y[m] - at.y()) / scale;
        if (dx * dx + dy * dy > 16) continue;
        const int bits = hamming(a.descriptor[k], b.descriptor[m]);
        if (bits < best) {
          best = bits;
          error = std::hypot(dx, dy);
        }
      }
      if (best < 60) {
        ++found;
        errors.push_back(error);
      }
    }
    EXPECT_GE(std::count_if(cells.begin(), cells.end(), [](int n) { return n > 0; }), 36) << i;
  }
  EXPECT_GT(expected, total / 2);
  // Real recordings reach about 55 % at this distance.
  EXPECT_GT(found, 0.45 * expected);
  EXPECT_LT(quantile(errors, 0.5), 0.8);
}

}  // namespace
}  // namespace covis
