// SPDX-License-Identifier: Apache-2.0
// Faults of cameras on small rendered recordings; `faults` of bench/ has all of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "faults/fault_run.h"

namespace covis::faults {
namespace {

constexpr int kFrames = 60, kRate = 10;
constexpr double kMostError = 0.05;  // metres, median of the sure frames

SynthOptions options_of(Sensor sensor, double rate) {
  SynthOptions options;
  options.sensor = name(sensor);
  options.width = 320;
  options.height = 240;
  options.fps = rate;
  options.noise = 2;
  return options;
}

GoodRecording& recording(Sensor sensor) {
  const auto make = [](Sensor of) { return RenderedRecording(options_of(of, kRate), kFrames); };
  static RenderedRecording stereo = make(Sensor::stereo), rgbd = make(Sensor::rgbd);
  return sensor == Sensor::stereo ? stereo : rgbd;
}

Fault named(std::vector<Fault> faults, const std::string& name) {
  const auto at = std::find_if(faults.begin(), faults.end(), [&](const Fault& f) { return f.name == name; });
  EXPECT_NE(at, faults.end()) << name;
  return at == faults.end() ? Fault{} : *at;
}

FaultResult always(Sensor sensor, const std::string& name) {
  return run_fault(recording(sensor), named(sensor_faults(sensor), name), {0, kFrames});
}

FaultResult for_a_while(Sensor sensor, const std::string& name) {
  return run_fault(recording(sensor), named(stream_faults(sensor), name), {25, 33});
}

TEST(Faults, AGoodRecordingIsNotDoubted) {
  for (const Sensor sensor : {Sensor::stereo, Sensor::rgbd}) {
    const FaultResult r = run_fault(recording(sensor), {}, {kFrames, kFrames});
    EXPECT_EQ(r.warned_after, -1) << name(sensor);
    EXPECT_EQ(r.sure_outside, kFrames) << name(sensor);
    EXPECT_EQ(r.wrong_outside, 0) << name(sensor);
    EXPECT_LT(r.median_error, kMostError) << name(sensor);
  }
}

void expect_doubted(Sensor sensor, const std::string& fault) {
  const FaultResult r = always(sensor, fault);
  EXPECT_GE(r.warned_after, 0) << fault;
  EXPECT_LT(r.warned_after, 50) << fault;
  EXPECT_LE(r.sure_within, r.warned_after) << fault << ": sure of a pose after the warning";
}

TEST(Faults, RandomDepthIsDoubted) { expect_doubted(Sensor::rgbd, "random"); }

TEST(Faults, MirroredDepthIsDoubted) { expect_doubted(Sensor::rgbd, "mirrored"); }

TEST(Faults, ARightImageThatIsNoneIsDoubted) { expect_doubted(Sensor::stereo, "left_twice"); }

TEST(FaultsLong, ALateRightImageIsDoubted) { expect_doubted(Sensor::stereo, "late_2"); }

FaultResult expect_recovery(const std::string& fault, Sensor sensor = Sensor::rgbd) {
  const FaultResult r = for_a_while(sensor, fault);
  EXPECT_EQ(r.wrong_outside, 0) << fault;
  EXPECT_GE(r.recovered_after, 0) << fault;
  EXPECT_LE(r.recovered_after, kRate) << fault;
  EXPECT_LT(r.median_error, kMostError) << fault;
  return r;
}

// No point is mapped from such depth; images alone carry the camera through.
TEST(Faults, DepthThatIsNonsenseForAWhileLeavesTheMapRight) {
  for (const char* fault : {"depth_inverse", "depth_scale_five"})
    EXPECT_EQ(expect_recovery(fault).sure_within, 0) << fault;
}

TEST(FaultsLong, ARightImageThatIsWrongForAWhileLeavesTheMapRight) {
  EXPECT_EQ(expect_recovery("right_left_twice", Sensor::stereo).sure_within, 0);
}

TEST(Faults, AStreamRecovers) {
  for (const char* fault : {"black", "noise"}) expect_recovery(fault);
}

// Their rows bent the map: all frames after them were wrong.
TEST(FaultsLong, NothingIsMappedFromTornImages) {
  for (const Sensor sensor : {Sensor::stereo, Sensor::rgbd}) EXPECT_LE(expect_recovery("torn", sensor).sure_within, 2);
}

// The camera leaves behind what it knows, so that nothing known is seen displaced any more.
TEST(FaultsLong, NothingIsMappedFromImagesThatAreTornForLong) {
  RenderedRecording longer(options_of(Sensor::stereo, 15), 110);
  const FaultResult r = run_fault(longer, named(stream_faults(Sensor::stereo), "torn"), {60, 84});
  EXPECT_EQ(r.wrong_outside, 0);
  EXPECT_GE(r.sure_after, 0);
  EXPECT_LE(r.sure_after, 15);
  EXPECT_EQ(r.sure_within, 0);
}

// Back in what it knows the camera makes no key frame that could show depth to be right again.
TEST(FaultsLong, DepthThatIsRightAgainIsSoonBelieved) {
  SynthOptions options = options_of(Sensor::rgbd, 15);
  options.world = "desk";
  options.depth_noise = 1;
  RenderedRecording desk(options, 150);
  const FaultResult r = run_fault(desk, named(stream_faults(Sensor::rgbd), "turned_round"), {60, 84});
  EXPECT_EQ(r.wrong_outside, 0);
  EXPECT_GE(r.sure_after, 0);
  EXPECT_LE(r.sure_after, 20);
}

// Its view has left the map meanwhile, and the next map is on probation.
TEST(FaultsLong, AMapBegunAfterAFaultIsSoonBelieved) {
  SynthOptions options = options_of(Sensor::rgbd, 15);
  options.noise = 2;
  options.depth_noise = 1;
  options.width = 640, options.height = 480;
  RenderedRecording room(options, 120);
  const FaultResult r = run_fault(room, named(stream_faults(Sensor::rgbd), "turned_round"), {60, 84});
  EXPECT_EQ(r.wrong_outside, 0);
  EXPECT_GE(r.found_after, 0);
  EXPECT_LE(r.found_after, 10);
  EXPECT_GE(r.sure_after, 0);
  EXPECT_LE(r.sure_after, 15);
}

TEST(FaultsLong, AStreamRecoversFromMore) {
  for (const char* fault : {"dropped", "stamps_back", "other_size"}) expect_recovery(fault);
}

}  // namespace
}  // namespace covis::faults
