// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/lens_answers.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <vector>

#include "covis/optimization/test_lens_problem.h"

namespace covis {
namespace {

using lens_test::camera_with;
using lens_test::kFocal;
using lens_test::Motion;
using lens_test::seen_through;

constexpr size_t kRichest = kLensModels - 1;
constexpr double kLongerSide = 640;

// An answer of a map that leaves `stays` of the error of the focal length it was tracked with. All models find the same
// lens, each what it may, as well as `sigma` tells.
LensAnswer answer_at(double given, double stays, const Lens& truth, const Lens& sigma) {
  LensAnswer answer{.given = given, .found = {}, .key_frames = 30};
  for (size_t model = 0; model < kLensModels; ++model) {
    LensAdjustment& found = answer.found[model];
    found.ok = true;
    found.lens.focal = truth.focal * std::pow(given / truth.focal, stays);
    found.sigma.focal = sigma.focal;
    if (model > 0) found.lens.k1 = truth.k1, found.sigma.k1 = sigma.k1;
    if (model > 1) found.lens.k2 = truth.k2, found.scatter.k2 = sigma.k2;
    if (model > 2) found.lens.cx = truth.cx, found.lens.cy = truth.cy, found.sigma.cx = found.sigma.cy = sigma.cx;
  }
  return answer;
}

const Lens kSigma{.focal = 0.004, .k1 = 0.01, .k2 = 0.01, .cx = 2, .cy = 2};

std::vector<LensAnswer> both_sides(const Lens& truth, double stays = 0.2) {
  return {answer_at(0.95 * kFocal, stays, truth, kSigma), answer_at(1.06 * kFocal, stays, truth, kSigma)};
}

TEST(LensAnswers, TheFocalLengthThatGivesItselfIsFoundWhereMapsKeepAPartOfAnError) {
  for (const double stays : {0.0, 0.3, 0.6}) {
    const auto settled = settle(both_sides({.focal = kFocal}, stays), {.focal = 1.02 * kFocal}, kLongerSide);
    ASSERT_TRUE(settled);
    EXPECT_NEAR(settled->lens.focal, kFocal, 1e-6 * kFocal) << stays;
    EXPECT_NEAR(settled->change, std::log(1.02), 1e-6);
    EXPECT_NEAR(settled->sigma.focal, 0.004 / (1 - stays), 1e-6) << "the less a map takes away, the less is known";
    EXPECT_FALSE(settled->repeats);
  }
}

TEST(LensAnswers, MapsThatGiveBackWhatTheyWereGivenTellNothing) {
  const auto settled = settle(both_sides({.focal = kFocal}, 0.9), {.focal = kFocal}, kLongerSide);
  ASSERT_TRUE(settled);
  EXPECT_TRUE(settled->repeats);
}

TEST(LensAnswers, WhatIsLessSureMustShowMore) {
  LensAnswer answer = answer_at(kFocal, 0, {.focal = kFocal, .k1 = 0.035}, kSigma);
  EXPECT_EQ(believed(answer), &answer.found[1]);
  scale_deviations(answer, 1.25);
  EXPECT_EQ(believed(answer), &answer.found[0]);
  EXPECT_NEAR(believed(answer)->deviation().focal, 1.25 * kSigma.focal, 1e-12);
}

// Between answers so near one another a small error by chance looks like a map that keeps much of an error, or nothing.
TEST(LensAnswers, NearOneAnotherTakeTheFallOfOthers) {
  std::vector<LensAnswer> answers{answer_at(0.99 * kFocal, 0.2, {.focal = kFocal}, kSigma),
                                  answer_at(1.01 * kFocal, 0.2, {.focal = kFocal}, kSigma)};
  for (LensAdjustment& found : answers[0].found) found.lens.focal *= 0.996;
  const auto alone = settle(answers, {.focal = kFocal}, kLongerSide);
  const auto helped = settle(answers, {.focal = kFocal}, kLongerSide, 0.8);
  ASSERT_TRUE(alone && helped);
  EXPECT_NEAR(helped->fall, 0.8, 1e-9);
  EXPECT_NEAR(std::log(helped->lens.focal / kFocal), 0.5 * std::log(0.996) / 0.8, 1e-4);
  EXPECT_LT(alone->fall, 0.65);
  EXPECT_LT(alone->lens.focal, helped->lens.focal);
}

TEST(LensAnswers, FarAwayDoNotCount) {
  std::vector<LensAnswer> answers = both_sides({.focal = kFocal});
  answers.push_back(answer_at(1.3 * kFocal, 0.9, {.focal = kFocal}, kSigma));
  const auto settled = settle(answers, {.focal = kFocal}, kLongerSide);
  ASSERT_TRUE(settled);
  EXPECT_NEAR(settled->lens.focal, kFocal, 1e-6 * kFocal);
  EXPECT_FALSE(settle(answers, {.focal = 3 * kFocal}, kLongerSide)) << "none is near";
}

TEST(LensAnswers, WhatTheyMissTheLineByIsUncertain) {
  std::vector<LensAnswer> answers = both_sides({.focal = kFocal});
  answers.push_back(answer_at(kFocal, 0, {.focal = 1.05 * kFocal}, kSigma));
  const auto settled = settle(answers, {.focal = kFocal}, kLongerSide);
  ASSERT_TRUE(settled);
  EXPECT_GT(settled->sigma.focal, 0.02);
}

// The models agree but for the richest one's focal length, so that what is chosen shows.
TEST(LensAnswers, WhatDoesNotShowIsLeftOutAndStaysUncertain) {
  const Lens unclear{.focal = kFocal, .k1 = 0.02, .k2 = 0.02, .cx = 4, .cy = -4};
  std::vector<LensAnswer> answers = both_sides(unclear);
  for (LensAnswer& answer : answers) answer.found[kRichest].lens.focal *= 1.01;
  for (const LensAnswer& answer : answers) EXPECT_EQ(believed(answer), &answer.found[0]);
  const auto settled = settle(answers, {.focal = kFocal}, kLongerSide);
  ASSERT_TRUE(settled);
  EXPECT_NEAR(settled->lens.focal, kFocal, 1e-6 * kFocal);
  EXPECT_EQ(settled->lens.k1, 0);
  EXPECT_EQ(settled->lens.k2, 0);
  EXPECT_EQ(settled->lens.cx, 0);
  EXPECT_NEAR(settled->sigma.focal, std::hypot(0.005, 0.5 * std::log(1.01) / 0.8), 1e-5)
      << "one of four models says more";
  EXPECT_NEAR(settled->sigma.k1, kSigma.k1, 1e-9);
  EXPECT_NEAR(settled->sigma.k2, kSigma.k2, 1e-9);
  EXPECT_NEAR(settled->sigma.cy, kSigma.cy, 1e-9);
}

// Two coefficients that can stand for one another are each unclear where both are free, and clear where one is.
TEST(LensAnswers, WhatShowsInASimplerModelIsKept) {
  const Lens truth{.focal = kFocal, .k1 = 0.06};
  std::vector<LensAnswer> answers = both_sides(truth);
  for (LensAnswer& answer : answers) {
    for (size_t model = 2; model < kLensModels; ++model) answer.found[model].scatter.k1 = 0.1;
    EXPECT_EQ(believed(answer), &answer.found[1]);
  }
  const auto settled = settle(answers, {.focal = kFocal}, kLongerSide);
  ASSERT_TRUE(settled);
  EXPECT_NEAR(settled->lens.k1, truth.k1, 1e-9);
  EXPECT_NEAR(settled->sigma.k1, kSigma.k1, 1e-9) << "that of the model that is believed";
  EXPECT_NEAR(settled->sigma.k2, kSigma.k2, 1e-9) << "that of the model that has it";
}

TEST(LensAnswers, WhatTheyDoNotAgreeOnDoesNotShow) {
  const Lens left{.focal = kFocal, .cx = -10}, right{.focal = kFocal, .cx = 40};
  const std::vector<LensAnswer> answers{answer_at(0.95 * kFocal, 0.2, left, kSigma),
                                        answer_at(1.06 * kFocal, 0.2, right, kSigma)};
  const auto settled = settle(answers, {.focal = kFocal}, kLongerSide);
  ASSERT_TRUE(settled);
  EXPECT_EQ(settled->lens.cx, 0);
  EXPECT_GT(settled->sigma.cx, 20);
}

TEST(LensAnswers, WhatShowsIsKept) {
  struct Shown {
    Lens truth;
    size_t model;
  };
  for (const auto& [truth, model] : {Shown{{.focal = kFocal, .k1 = -0.05}, 1}, Shown{{.focal = kFocal, .k2 = 0.05}, 2},
                                     Shown{{.focal = kFocal, .k1 = -0.1, .k2 = 0.05}, 2},
                                     Shown{{.focal = kFocal, .cx = -9}, 3}, Shown{{.focal = kFocal, .cy = 9}, 3}}) {
    const std::vector<LensAnswer> answers = both_sides(truth);
    EXPECT_EQ(believed(answers[0]), &answers[0].found[model]);
    const auto settled = settle(answers, {.focal = kFocal}, kLongerSide);
    ASSERT_TRUE(settled);
    EXPECT_NEAR(settled->lens.k1, truth.k1, 1e-9);
    EXPECT_NEAR(settled->lens.k2, truth.k2, 1e-9);
    EXPECT_NEAR(settled->lens.cx, truth.cx, 1e-9);
    EXPECT_NEAR(settled->lens.cy, truth.cy, 1e-9);
  }
}

TEST(LensAnswers, AModelThatOneOfThemLacksIsNotBelieved) {
  const Lens truth{.focal = kFocal, .k1 = -0.1, .k2 = 0.05, .cx = 20};
  std::vector<LensAnswer> answers = both_sides(truth);
  answers[1].found[kRichest].ok = false;
  EXPECT_EQ(believed(answers[1]), &answers[1].found[2]);
  auto settled = settle(answers, {.focal = kFocal}, kLongerSide);
  ASSERT_TRUE(settled);
  EXPECT_EQ(settled->lens.cx, 0);
  EXPECT_NEAR(settled->sigma.cx, 0.02 * kLongerSide, 1e-9) << "nothing is known but what is usual";
  EXPECT_NEAR(settled->lens.k2, truth.k2, 1e-9);
  EXPECT_NEAR(settled->sigma.k2, kSigma.k2, 1e-9);
  for (size_t model = 0; model < kRichest; ++model) answers[0].found[model].ok = false;
  EXPECT_FALSE(settle(answers, {.focal = kFocal}, kLongerSide));
  for (LensAdjustment& found : answers[0].found) found.ok = false;
  EXPECT_EQ(believed(answers[0]), nullptr);
}

// The lens to be believed of a map that was seen through `lens` with its principal point so far off the middle, and
// made with a focal length that is 4 % too long.
Lens told(const Lens& lens, double off) {
  BundleProblem problem = seen_through(camera_with(lens), 1.04, Motion::sideways, 5);
  problem.camera.cx -= off;
  const LensAnswer answer = answer_of(problem, {1.04 * kFocal}, kLongerSide);
  EXPECT_NE(believed(answer), nullptr);
  return believed(answer) ? believed(answer)->lens : Lens{};
}

TEST(LensAnswers, AMapTellsAsMuchOfItsLensAsShows) {
  const Lens exact = told({kFocal}, 0), bent = told({kFocal, -0.26, 0.08}, 0), off = told({kFocal, -0.1}, 12);
  for (const Lens& lens : {exact, bent, off}) EXPECT_NEAR(lens.focal, kFocal, 0.01 * kFocal);
  EXPECT_EQ(exact.k1, 0);
  EXPECT_EQ(exact.k2, 0);
  EXPECT_EQ(bent.cx, 0);
  EXPECT_NEAR(bent.k1, -0.26, 0.02);
  EXPECT_NEAR(bent.k2, 0.08, 0.03);
  EXPECT_NEAR(off.cx, 12, 2);
  EXPECT_NEAR(off.k1, -0.1, 0.02);
}

TEST(LensAnswers, APrincipalPointThatNoLensHasIsNotBelieved) {
  EXPECT_NEAR(told({kFocal}, 30).cx, 30, 3);
  EXPECT_EQ(told({kFocal}, 60).cx, 0) << "a tenth of the image: something else is wrong";
}

TEST(LensAnswers, OfAnInterruptedAdjustmentNothingIsBelieved) {
  BundleProblem problem = seen_through(camera_with({kFocal}), 1, Motion::sideways, 5);
  const std::atomic<int> interrupt = 2;
  EXPECT_EQ(believed(answer_of(problem, {kFocal}, kLongerSide, &interrupt)), nullptr);
}

TEST(LensAnswers, OfAMapWithoutPosesNothingIsBelieved) {
  BundleProblem problem;
  const LensAnswer answer = answer_of(problem, {.focal = kFocal}, kLongerSide);
  EXPECT_EQ(answer.given, kFocal);
  EXPECT_EQ(answer.key_frames, 0);
  EXPECT_EQ(believed(answer), nullptr);
}

}  // namespace
}  // namespace covis
