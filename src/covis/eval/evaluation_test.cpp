// SPDX-License-Identifier: Apache-2.0
#include "covis/eval/evaluation.h"

#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace covis {
namespace {

constexpr Timestamp kStep = 100'000'000;

// A winding path, 10 poses a second, about 1 m apart.
Trajectory path(int count) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    trajectory.push_back({i * kStep, SE3(so3_exp({0, 0.05 * i, 0.01 * i}),
                                         Eigen::Vector3d(10 * std::sin(0.1 * i), 0.02 * i, 10 * std::cos(0.1 * i)))});
  }
  return trajectory;
}

Trajectory moved(const Trajectory& t, const SE3& T, double scale = 1) {
  Trajectory result;
  for (const StampedPose& p : t)
    result.push_back(
        {p.stamp, SE3(Eigen::Matrix3d(T.R() * p.T_wc.R()), Eigen::Vector3d(scale * (T.R() * p.T_wc.t()) + T.t()))});
  return result;
}

const SE3 kMotion(so3_exp({0.3, -1.2, 0.7}), Eigen::Vector3d(5, -3, 8));

TEST(Evaluation, AMovedCopyHasNoError) {
  const Trajectory truth = path(100);
  const auto e = evaluate(moved(truth, kMotion), truth, {});
  ASSERT_TRUE(e);
  EXPECT_LT(e->ate.rmse, 1e-9);
  EXPECT_LT(e->rotation_deg.max, 1e-5);
  EXPECT_LT(e->rpe_translation.max, 1e-9);
  EXPECT_EQ(e->coverage, 1);
  EXPECT_EQ(e->rpe_pairs, 99u);
  EXPECT_TRUE(e->unique_alignment);
}

TEST(Evaluation, ScaleIsFoundBySim3Only) {
  const Trajectory truth = path(100);
  const auto sim3 = evaluate(moved(truth, kMotion, 0.5), truth, {.align = AlignMode::sim3});
  EXPECT_LT(sim3->ate.rmse, 1e-9);
  EXPECT_NEAR(sim3->scale, 2, 1e-9);
  EXPECT_GT(evaluate(moved(truth, kMotion, 0.5), truth, {})->ate.rmse, 1);
}

TEST(Evaluation, AKnownOffsetWithoutAlignment) {
  const Trajectory truth = path(50);
  const auto e = evaluate(moved(truth, SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(3, 0, 4))), truth,
                          {.align = AlignMode::none});
  EXPECT_NEAR(e->ate.rmse, 5, 1e-9);
  EXPECT_NEAR(e->ate.median, 5, 1e-9);
  EXPECT_NEAR(e->ate.max, 5, 1e-9);
}

// Scaled to nothing every path fits.
TEST(Evaluation, ATruthInOnePlaceHasNoScale) {
  Trajectory path, place;
  for (int i = 0; i < 5; ++i) {
    path.push_back({i * 1'000'000'000LL, SE3(Eigen::Matrix3d::Identity(), {0.1 * i, 0, 0.05 * i * i})});
    place.push_back({i * 1'000'000'000LL, SE3()});
  }
  const auto scaled = evaluate(path, place, {.align = AlignMode::sim3});
  ASSERT_FALSE(scaled);
  EXPECT_EQ(scaled.error().message, "there is no scale to align with: in the truth all positions are the same");
}

// Bent by one degree after its middle: aligned by the first pose the end is as far off as that swings it.
TEST(Evaluation, ByTheFirstPoseAPathStrays) {
  const Trajectory truth = path(100);
  Trajectory bent = truth;
  const SE3 middle = truth[50].T_wc;
  const SE3 bend = middle * SE3(so3_exp({0, std::numbers::pi / 180, 0}), {0, 0, 0}) * middle.inverse();
  for (size_t i = 51; i < bent.size(); ++i) bent[i].T_wc = bend * bent[i].T_wc;
  const double end = (bent.back().T_wc.t() - truth.back().T_wc.t()).norm();
  ASSERT_GT(end, 1e-3);
  const auto rigid = evaluate(moved(bent, kMotion, 1), truth, {.align = AlignMode::first});
  ASSERT_TRUE(rigid) << rigid.error().message;
  EXPECT_NEAR(rigid->compared.front().error, 0, 1e-9);
  EXPECT_NEAR(rigid->compared[50].error, 0, 1e-9);
  EXPECT_NEAR(rigid->compared.back().error, end, 1e-9);
  EXPECT_EQ(rigid->scale, 1);
  const auto scaled = evaluate(moved(truth, kMotion, 0.5), truth, {.align = AlignMode::first_sim3});
  ASSERT_TRUE(scaled) << scaled.error().message;
  EXPECT_NEAR(scaled->scale, 2, 1e-9);
  EXPECT_NEAR(scaled->ate.max, 0, 1e-9);
  EXPECT_NEAR(scaled->rotation_deg.max, 0, 1e-5);
}

TEST(Evaluation, RelativeAndKittiErrorsOfAStretchedPath) {
  Trajectory truth, estimate;  // straight on, 1 m a pose, the estimate 1 % too long
  for (int i = 0; i < 400; ++i) {
    truth.push_back({i * kStep, SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, i))});
    estimate.push_back({i * kStep, SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, 1.01 * i))});
  }
  const auto e = evaluate(estimate, truth, {});
  ASSERT_TRUE(e);
  EXPECT_NEAR(e->rpe_translation.rmse, 0.01, 1e-9);
  EXPECT_NEAR(e->path_length, 399, 1e-9);
  ASSERT_TRUE(e->kitti);
  EXPECT_TRUE(e->kitti->standard);
  EXPECT_NEAR(e->kitti->t_rel_percent, 1, 0.02);
  EXPECT_NEAR(e->kitti->r_rel_deg_100m, 0, 1e-9);
  EXPECT_THAT(e->kitti->lengths, testing::ElementsAre(100, 200, 300));
  EXPECT_FALSE(e->unique_alignment);  // a straight line
  EXPECT_NEAR(evaluate(estimate, truth, {.delta = 10, .delta_unit = DeltaUnit::metres})->rpe_translation.rmse, 0.1,
              1e-9);
  EXPECT_NEAR(evaluate(estimate, truth, {.delta = 2, .delta_unit = DeltaUnit::seconds})->rpe_translation.rmse, 0.2,
              1e-9);

  const auto longer = evaluate(estimate, truth, {.delta = 1e6, .delta_unit = DeltaUnit::metres});
  EXPECT_EQ(longer->rpe_pairs, 0u);
  EXPECT_THAT(to_text(*longer), testing::HasSubstr("RPE             none: no two poses"));
  EXPECT_TRUE(to_json(*longer)["rpe_m"].is_null()) << "an error of 0 would look like a good one";
  EXPECT_EQ(to_json(*e)["rpe_m"]["rmse"], e->rpe_translation.rmse);
}

TEST(Evaluation, AKnownTurnPerMetre) {
  Trajectory truth, estimate;
  for (int i = 0; i < 300; ++i) {
    truth.push_back({i * kStep, SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, i))});
    estimate.push_back({i * kStep, SE3(so3_exp({0, 0.001 * i, 0}), Eigen::Vector3d(0, 0, i))});
  }
  const auto e = evaluate(estimate, truth, {.align = AlignMode::none});
  EXPECT_NEAR(e->kitti->r_rel_deg_100m, 0.1 * 180 / M_PI, 1e-6);
  EXPECT_NEAR(e->rpe_rotation_deg.rmse, 0.001 * 180 / M_PI, 1e-9);
}

TEST(Evaluation, FramesWithoutTruthAreDropped) {
  const Trajectory truth = path(100);
  Trajectory half(truth.begin(), truth.begin() + 50);
  const auto e = evaluate(truth, half, {});  // the estimate goes on where the truth has ended
  EXPECT_EQ(e->associated, 50u);
  EXPECT_EQ(e->coverage, 1);
  EXPECT_LT(e->ate.rmse, 1e-9);
  EXPECT_NEAR(evaluate(half, truth, {})->coverage, 0.5, 1e-12);
  // A hole in the ground truth is not interpolated over.
  Trajectory holed;
  for (size_t i = 0; i < truth.size(); ++i) {
    if (i < 40 || i >= 60) holed.push_back(truth[i]);
  }
  EXPECT_EQ(evaluate(truth, holed, {})->associated, 80u);
}

TEST(Evaluation, TruthIsInterpolatedBetweenNearPoses) {
  Trajectory truth, estimate;
  for (int i = 0; i < 50; ++i)
    truth.push_back({i * kStep, SE3(so3_exp({0, 0.02 * i, 0}), Eigen::Vector3d(i, 0.5 * i, std::sin(0.2 * i)))});
  for (int i = 0; i < 49; ++i) {
    estimate.push_back(
        {i * kStep + kStep / 2,
         SE3(so3_exp({0, 0.02 * i + 0.01, 0}), Eigen::Vector3d(0.5 * (truth[static_cast<size_t>(i)].T_wc.t() +
                                                                      truth[static_cast<size_t>(i) + 1].T_wc.t())))});
  }
  const auto e = evaluate(estimate, truth, {.align = AlignMode::none});
  EXPECT_EQ(e->associated, 49u);
  EXPECT_LT(e->ate.max, 1e-9);
  EXPECT_LT(e->rotation_deg.max, 1e-5);
}

TEST(Evaluation, DuplicatesAndOrderDoNotMatter) {
  const Trajectory truth = path(30);
  Trajectory shuffled(truth.rbegin(), truth.rend());
  shuffled.push_back(truth[5]);
  const auto e = evaluate(shuffled, truth, {});
  EXPECT_EQ(e->associated, 30u);
  EXPECT_LT(e->rpe_translation.max, 1e-9);
}

TEST(Evaluation, TooLittleIsAnError) {
  const Trajectory truth = path(30);
  const Trajectory two(truth.begin(), truth.begin() + 2);
  EXPECT_THAT(evaluate(two, truth, {}).error().message, testing::HasSubstr("at least 3"));
  Trajectory elsewhere = truth;
  for (StampedPose& p : elsewhere) p.stamp += 1000'000'000'000;
  const auto e = evaluate(elsewhere, truth, {});
  ASSERT_FALSE(e);
  EXPECT_THAT(e.error().message, testing::AllOf(testing::HasSubstr("from 0.000"), testing::HasSubstr("from 1000.000")));
  EXPECT_FALSE(evaluate({}, truth, {}));
  EXPECT_FALSE(evaluate(truth, {}, {}));
}

TEST(Evaluation, JsonAndTextHoldTheFigures) {
  const Trajectory truth = path(30);
  const auto e = evaluate(moved(truth, kMotion), truth, {});
  const nlohmann::json json = to_json(*e);
  EXPECT_EQ(json["associated"], 30);
  EXPECT_NEAR(json["ate_m"]["rmse"].get<double>(), 0, 1e-9);
  EXPECT_FALSE(json["kitti"]["standard_lengths"].get<bool>());
  EXPECT_THAT(to_text(*e), testing::HasSubstr("ATE"));
}

}  // namespace
}  // namespace covis
