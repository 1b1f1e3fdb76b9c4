// SPDX-License-Identifier: Apache-2.0
// Bags of ROS through the command.
#include "command_results.h"
#include "covis/io/bag.h"
#include "covis/io/sequence.h"
#include "covis/io/test_bags.h"

namespace covis {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Copies an image's rows without gaps.
template <class T>
std::string pixels(const Image<T>& image) {
  std::string bytes;
  for (int y = 0; y < image.height(); ++y)
    bytes.append(reinterpret_cast<const char*>(image.row(y)), static_cast<size_t>(image.width()) * sizeof(T));
  return bytes;
}

// Writes a recording's frames as a bag.
void convert(const fs::path& recording, const fs::path& file, io::RosWire wire) {
  const auto opened = io::open_sequence(recording, {});
  ASSERT_TRUE(opened) << opened.error().message;
  const Camera& camera = (*opened)->camera();
  const std::array<uint32_t, 2> size{static_cast<uint32_t>(camera.width), static_cast<uint32_t>(camera.height)};
  io::RosCameraInfo info = io::camera_info();
  info.width = size[0];
  info.height = size[1];
  info.K = {camera.pinhole.fx, 0, camera.pinhole.cx, 0, camera.pinhole.fy, camera.pinhole.cy, 0, 0, 1};
  io::WrittenBag bag(wire);
  bag.add("/camera/color/camera_info", info);
  for (auto frame = (*opened)->next(); frame && *frame; frame = (*opened)->next()) {
    const Timestamp stamp = std::max<Timestamp>(1, (*frame)->stamp);  // 0 in a message of ROS means none
    bag.add_image("/camera/color/image_raw", stamp, "mono8", pixels((*frame)->image), size);
    if (!(*frame)->depth.empty())
      bag.add_image("/camera/aligned_depth_to_color/image_raw", stamp, "32FC1", pixels((*frame)->depth), size);
  }
  bag.write(file);
}

using CommandBag = CommandTest;

TEST_F(CommandBag, GivesTheTrajectoryOfTheFolderItWasMadeFromLong) {
  for (const auto& [sensor, name, wire] : {std::tuple{"mono", "recording.bag", io::RosWire::ros1},
                                           std::tuple{"rgbd", "recording.db3", io::RosWire::cdr}}) {
    SCOPED_TRACE(sensor);
    if (wire == io::RosWire::ros1 && !io::reads_ros1_bags()) continue;
    const fs::path recording = render(sensor, 20), bag = folder / name;
    ASSERT_NO_FATAL_FAILURE(convert(recording, bag, wire));
    // Without the first frame, whose stamp in the bag is another.
    ASSERT_EQ(covis({"run", recording, "--first", "1", "--quiet", "--out", folder / "folder"}).code, 0);
    std::vector<std::string> run{"run", bag, "--first", "1", "--quiet", "--out", folder / "bag"};
    // The noise of depth is nothing that a bag says.
    if (wire == io::RosWire::cdr) run.insert(run.end(), {"--camera", recording / "camera.yaml"});
    const Outcome outcome = covis(run);
    ASSERT_EQ(outcome.code, 0) << outcome.error;
    for (const char* file : {"trajectory.txt", "trajectory_online.txt"}) {
      const std::string wanted = text_of(folder / "folder" / file);
      EXPECT_GT(wanted.size(), 100u);
      EXPECT_EQ(text_of(folder / "bag" / file), wanted);
    }
    const Outcome check = covis({"check", bag, "--json", "--out", folder / "check.png"});
    const json found = json::parse(check.out, nullptr, false);
    EXPECT_EQ(found["kind"], "bag") << check.error;
    EXPECT_EQ(found["sensor"], sensor);
    EXPECT_EQ(found["frames_read"], 20);
    const Outcome unknown = covis({"run", bag, "--topic", "/front/image", "--out", folder / "none"});
    EXPECT_EQ(unknown.code, 1);
    EXPECT_THAT(unknown.error, AllOf(HasSubstr("/front/image"), HasSubstr("/camera/color/image_raw")));
  }
}

}  // namespace
}  // namespace covis
