// SPDX-License-Identifier: Apache-2.0
// The public interface, as a program sees it, on rendered recordings: frames, snapshots, events, threads. Its refusals
// are in src/covis/api/slam_test.cpp.
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <map>
#include <set>
#include <thread>

#include "api_frames.h"
#include "covis/core/test_folder.h"
#include "covis/features/rectification.h"
#include "covis/geometry/alignment.h"

namespace covis {
namespace {

using ::testing::HasSubstr;

class Api : public testing::TestWithParam<Sensor> {};

INSTANTIATE_TEST_SUITE_P(Sensors, Api, testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd),
                         [](const auto& instance) { return sensor_name(instance.param); });

TEST_P(Api, TracksLocatesAndRefusesWhatDoesNotFit) {
  Recording& recording = shared_recording(GetParam(), 30, 15, "desk");
  const auto slam = Slam::create(options_of(recording)).value();
  const auto early = slam->locate(frame_of(recording.frame(0)));
  ASSERT_TRUE(early) << early.error();
  EXPECT_FALSE(*early);  // there is no map yet

  const int tracked = track_all(*slam, recording, 0, recording.size() - 1);
  slam->finish();
  EXPECT_GT(tracked, 15);
  const auto trajectory = slam->trajectory();
  ASSERT_GE(trajectory.size(), 15u);
  expect_turned_as(recording.synth, trajectory);

  // The last tracked image is found again from the image alone, at the same place; a black image is not.
  const auto last = trajectory.back();
  const auto found = slam->locate(frame_of(recording.frame(recording.size() - 1)));
  ASSERT_TRUE(found && *found);
  EXPECT_LT(apart((*found)->pose, last.pose), 0.03);
  EXPECT_LT(turned_deg((*found)->pose, last.pose), 1);
  const auto nowhere = slam->locate(frame_of(recording.black(0)));
  ASSERT_TRUE(nowhere) << nowhere.error();
  EXPECT_FALSE(*nowhere);

  // An error changes nothing.
  EXPECT_THAT(error_of(slam->track(frame_of(recording.frame(3)))), HasSubstr("stamps must rise"));
  EXPECT_EQ(slam->trajectory().size(), trajectory.size());
}

// In colour the poses are those of the grey images, and the points have the colours of what they show.
TEST_P(Api, PointsHaveTheColoursOfTheImages) {
  Recording& recording = shared_recording(GetParam(), 30, 15, "desk");
  const auto grey = Slam::create(options_of(recording)).value(), coloured = Slam::create(options_of(recording)).value();
  std::vector<uint8_t> bytes;
  for (int i = 0; i < recording.size(); ++i) {
    Frame frame = frame_of(recording.frame(i));
    const auto plain = grey->track(frame);
    const GreyImage& image = frame.image;
    bytes.clear();
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const uint8_t value = image.data[y * image.stride + x];
        bytes.insert(bytes.end(), {30, static_cast<uint8_t>(255 - value), value});
      }
    }
    frame.colour = {bytes.data(), image.width, image.height, 3 * static_cast<ptrdiff_t>(image.width), ColourOrder::bgr};
    const auto result = coloured->track(frame);
    ASSERT_TRUE(plain && result) << error_of(result);
    EXPECT_EQ(apart(plain->pose, result->pose), 0);
  }
  grey->finish();
  // Either lets mapping end first.
  if (GetParam() == Sensor::stereo) {
    coloured->finish();
  } else {
    ASSERT_TRUE(coloured->set_mode(Mode::localisation));
  }
  for (const MapSnapshot::Point& point : grey->snapshot()->points) EXPECT_EQ(point.colour, kNoColour);
  const auto snapshot = coloured->snapshot();
  ASSERT_GT(snapshot->points.size(), 100u);
  for (const MapSnapshot::Point& point : snapshot->points) {
    const auto& [red, green, blue] = point.colour;
    EXPECT_EQ(blue, 30);
    EXPECT_NEAR(red + green, 255, 1);
  }
}

// The points of the last frame project, by its pose, to where they were seen; its covariance is small and positive.
TEST_P(Api, AFrameTellsItsPointsAndItsCovariance) {
  Recording& recording = shared_recording(GetParam(), 30, 15, "desk");
  const auto slam = Slam::create(options_of(recording)).value();
  track_all(*slam, recording, 0, recording.size() - 2);
  const auto result = slam->track(frame_of(recording.frame(recording.size() - 1)));
  ASSERT_TRUE(result && result->tracked());
  const std::vector<TrackedPoint> points = slam->tracked_points();
  ASSERT_EQ(static_cast<int>(points.size()), result->inliers);
  const CameraParameters camera = slam->camera();
  std::set<uint64_t> ids;
  for (const TrackedPoint& p : points) {
    const Eigen::Vector3d from(p.x - result->pose.x, p.y - result->pose.y, p.z - result->pose.z);
    const Eigen::Vector3d p_c = orientation(result->pose).inverse() * from;
    EXPECT_LT(
        std::hypot(camera.fx * p_c.x() / p_c.z() + camera.cx - p.u, camera.fy * p_c.y() / p_c.z() + camera.cy - p.v),
        12);
    ids.insert(p.point);
  }
  EXPECT_GE(ids.size(), points.size() * 98 / 100) << "few points are shown twice";
  slam->finish();
  std::set<uint64_t> of_map;
  for (const MapSnapshot::Point& p : slam->snapshot()->points) of_map.insert(p.id);
  const auto known = std::count_if(ids.begin(), ids.end(), [&](uint64_t id) { return of_map.contains(id); });
  EXPECT_GT(known, static_cast<long>(ids.size() * 8 / 10)) << "the ids are those of the map";

  ASSERT_TRUE(result->covariance);
  for (int i = 0; i < 6; ++i) {
    const double sigma = std::sqrt((*result->covariance)[static_cast<size_t>(7 * i)]);
    EXPECT_GT(sigma, 1e-5);
    EXPECT_LT(sigma, 0.02);
  }
}

// An image of the same scene by a camera turned on the spot: R takes its rays to the given camera's.
ImageU8 turned(const ImageView<const uint8_t>& image, const Pinhole& camera, const Eigen::Matrix3d& R) {
  ResamplingMap map(image.width, image.height, image.width, image.height);
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const Eigen::Vector2d from = camera.project(R * camera.unproject(u, v));
      map.set(u, v, static_cast<float>(from.x()), static_cast<float>(from.y()));
    }
  }
  ImageU8 made;
  map.apply(image, made);
  return made;
}

// The right camera is turned against the left one by two degrees about each axis: the pair is rectified here, and the
// path is as true as that of the pair that was rectified before.
TEST(ApiStereo, APairThatIsNotRectifiedIsRectifiedHere) {
  Recording& recording = shared_recording(Sensor::stereo, 30, 15, "desk");
  SlamOptions options = options_of(recording);
  const Eigen::Matrix3d R = so3_exp(Eigen::Vector3d::Constant(2 * std::numbers::pi / 180));
  const Eigen::Quaterniond q(R);
  const double baseline = std::exchange(options.camera.baseline, 0);
  options.right =
      RightCamera{.camera = options.camera,
                  .pose = {.x = baseline, .y = 0, .z = 0, .qx = q.x(), .qy = q.y(), .qz = q.z(), .qw = q.w()}};
  const auto slam = Slam::create(options).value();
  EXPECT_NEAR(slam->camera().baseline, baseline, 1e-9);
  const Pose rectified = slam->rectified_left();
  EXPECT_GT(turned_deg(rectified, Pose()), 0.5) << "the cameras share the turn about the baseline";
  std::vector<Eigen::Vector3d> estimate, truth;
  for (int i = 0; i < recording.size(); ++i) {
    System::Input in = recording.frame(i);
    const ImageU8 right = turned(in.right, recording.synth.camera().pinhole, R);
    in.right = right.view();
    const auto result = slam->track(frame_of(in));
    ASSERT_TRUE(result && result->tracked()) << i;
    estimate.emplace_back(result->pose.x, result->pose.y, result->pose.z);
    truth.push_back(recording.synth.T_wc(i).t());
  }
  EXPECT_LT(align(estimate, truth, Scale::fixed)->rmse, 0.01);
}

// Everything a snapshot says agrees with everything else it says.
TEST_P(Api, ASnapshotIsSound) {
  Recording& recording = shared_recording(GetParam(), 30, 15, "desk");
  const auto slam = Slam::create(options_of(recording)).value();
  track_all(*slam, recording, 0, recording.size() - 1);
  slam->finish();
  const auto s = slam->snapshot();
  EXPECT_EQ(s, slam->snapshot()) << "nothing changed";
  ASSERT_EQ(s->submaps.size(), 1u);
  ASSERT_GE(s->key_frames.size(), 2u);
  EXPECT_EQ(s->submaps[0].key_frames, s->key_frames.size());
  EXPECT_EQ(s->submaps[0].points, s->points.size());
  EXPECT_EQ(s->submaps[0].frames, s->trajectory.size());
  EXPECT_EQ(s->camera.fx, slam->camera().fx);
  int roots = 0;
  for (size_t k = 0; k < s->key_frames.size(); ++k) {
    const MapSnapshot::KeyFrame& key_frame = s->key_frames[k];
    roots += key_frame.parent < 0;
    EXPECT_TRUE(k == 0 || s->key_frames[k - 1].id < key_frame.id);
    EXPECT_EQ(key_frame.stamp, recording.synth.stamp(static_cast<int>(key_frame.frame)));
    // Every key frame is a frame of the trajectory and has the same pose.
    const auto same = std::find_if(s->trajectory.begin(), s->trajectory.end(),
                                   [&](const TrajectoryPose& pose) { return pose.stamp == key_frame.stamp; });
    ASSERT_NE(same, s->trajectory.end());
    EXPECT_LT(apart(same->pose, key_frame.pose), 1e-6);
    EXPECT_LT(turned_deg(same->pose, key_frame.pose), 1e-4);
  }
  EXPECT_EQ(roots, 1);

  std::vector<int> observers(s->points.size());
  std::map<std::pair<uint32_t, uint32_t>, int> shared;  // of each two key frames
  std::vector<std::set<uint32_t>> seen(s->key_frames.size());
  for (const MapSnapshot::Observation& o : s->observations) {
    ASSERT_LT(o.key_frame, s->key_frames.size());
    ASSERT_LT(o.point, s->points.size());
    EXPECT_TRUE(o.u >= 0 && o.u < 320 && o.v >= 0 && o.v < 240);
    EXPECT_TRUE(seen[o.key_frame].insert(o.point).second);
    ++observers[o.point];
  }
  EXPECT_TRUE(std::all_of(observers.begin(), observers.end(), [](int n) { return n > 0; }));
  ASSERT_FALSE(s->edges.empty());
  for (const MapSnapshot::Edge& edge : s->edges) {
    ASSERT_LT(edge.a, edge.b);
    const auto both = std::count_if(seen[edge.a].begin(), seen[edge.a].end(),
                                    [&](uint32_t point) { return seen[edge.b].contains(point); });
    EXPECT_EQ(edge.shared, both);
    EXPECT_GE(edge.shared, 15);
    EXPECT_FALSE(edge.loop);
  }
}

// Events come in their order, and their handler may ask for all there is.
// A map that begins tells of a submap and of its first key frame.
TEST(ApiEvents, GoToTheHandlerItselfAndToAnotherFromTheNextOn) {
  Recording& recording = shared_recording(Sensor::rgbd, 60, 8);
  for (const bool ends : {false, true}) {
    const auto slam = Slam::create(options_of(recording)).value();
    std::vector<int> counts;
    slam->on_event([&, n = 0](const Event&) mutable {
      counts.push_back(++n);
      if (ends) slam->on_event({});
    });
    track_all(*slam, recording, 0, 29);
    slam->finish();
    if (ends) {
      EXPECT_EQ(counts.size(), 1u);
      continue;
    }
    ASSERT_GT(counts.size(), 2u);
    EXPECT_EQ(counts.back(), static_cast<int>(counts.size())) << "it keeps what it counts";
  }
}

TEST(ApiEvents, AreToldWithoutPolling) {
  Recording& recording = shared_recording(Sensor::rgbd, 60, 8);
  SlamOptions options = options_of(recording);
  options.settings = {{"tracker.new_map_after", "0"}};
  const auto slam = Slam::create(options).value();
  std::vector<Event> events;
  slam->on_event([&](const Event& event) {
    events.push_back(event);
    EXPECT_FALSE(slam->snapshot()->key_frames.empty());
  });
  track_all(*slam, recording, 0, 29);
  const auto count = [&](Event::Kind kind) {
    return std::count_if(events.begin(), events.end(), [&](const Event& e) { return e.kind == kind; });
  };
  EXPECT_EQ(count(Event::Kind::submap_begun), 1);
  EXPECT_EQ(count(Event::Kind::lost) + count(Event::Kind::found), 0);
  int64_t stamp = recording.synth.stamp(29);
  const auto show = [&](System::Input in) {
    in.stamp = stamp += from_seconds(0.125);
    return slam->track(frame_of(in)).value();
  };
  for (int i = 0; i < 3; ++i) show(recording.black(0));
  ASSERT_EQ(count(Event::Kind::lost), 1);
  const auto lost =
      std::find_if(events.begin(), events.end(), [](const Event& e) { return e.kind == Event::Kind::lost; });
  EXPECT_NE(lost->reason, NoPoseReason::none);
  EXPECT_EQ(lost->stamp, recording.synth.stamp(29) + from_seconds(0.125));
  for (int i = 29; i > 24; --i) show(recording.frame(i));
  EXPECT_EQ(count(Event::Kind::found), 1);
  slam->finish();
  EXPECT_EQ(count(Event::Kind::lost), 1);
  std::set<uint64_t> made;
  for (const Event& event : events) {
    if (event.key_frame) {
      EXPECT_TRUE(made.insert(*event.key_frame).second) << "each once";
    }
  }
  for (const auto& key_frame : slam->snapshot()->key_frames) EXPECT_TRUE(made.contains(key_frame.id));
  for (const Event& event : events) EXPECT_EQ(event.kind == Event::Kind::key_frame_made, event.key_frame.has_value());

  slam->on_event({});
  const size_t told = events.size();
  show(recording.black(0));
  EXPECT_EQ(events.size(), told);
}

// A viewer asks for all there is while frames are tracked, the map is saved and thrown away: each answer is sound, and
// the thread sanitizer finds no race.
TEST(ApiThreads, AnyThreadMayAskWhileFramesAreTracked) {
  Recording& recording = shared_recording(Sensor::rgbd, 30, 15, "desk");
  const TemporaryFolder folder;
  const std::string file = folder / "map.m";
  for (const Timing timing : {Timing::deterministic, Timing::realtime}) {
    SlamOptions options = options_of(recording);
    options.timing = timing;
    const auto slam = Slam::create(options).value();
    std::atomic<size_t> most_poses = 0, answers = 0;
    std::jthread viewer([&](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        const auto trajectory = slam->trajectory();
        const auto snapshot = slam->snapshot();
        EXPECT_TRUE(std::is_sorted(trajectory.begin(), trajectory.end(),
                                   [](const auto& a, const auto& b) { return a.stamp < b.stamp; }));
        EXPECT_TRUE(snapshot->points.empty() || !snapshot->key_frames.empty());
        EXPECT_GT(slam->camera().fx, 0);
        EXPECT_EQ(slam->rectified_left().qw, 1);
        EXPECT_FALSE(slam->settings().empty() || default_settings().empty());
        EXPECT_STRNE(name(slam->mode() == Mode::mapping ? TrackingState::lost : TrackingState::tracking), version());
        most_poses = std::max(most_poses.load(), trajectory.size());
        if (++answers % 8 == 0) (void)slam->save_map(file);
        answers.notify_all();
      }
    });
    set_log_sink([](LogLevel, std::string_view) {});
    const int tracked = track_all(*slam, recording, 0, recording.size() - 1);
    ASSERT_EQ(error_of(slam->set_mode(Mode::localisation)), "");
    EXPECT_TRUE(slam->locate(frame_of(recording.frame(5))));
    if (timing == Timing::deterministic) {
      EXPECT_EQ(tracked, recording.size());
    }
    // The map goes while the other thread looks at it.
    const size_t asked = answers;
    answers.wait(asked);
    slam->reset();
    EXPECT_TRUE(slam->trajectory().empty());
    answers.wait(answers.load());
    viewer.request_stop();
    viewer.join();
    set_log_sink({});
    EXPECT_GT(most_poses, 0u);
  }
}

}  // namespace
}  // namespace covis
