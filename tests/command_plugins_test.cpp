// SPDX-License-Identifier: Apache-2.0
// The command executed, not called within the test: what it loads, and that it finds its plug-ins.
#include "command_video.h"
#include "covis/io/bag.h"
#include "covis/io/test_bags.h"

namespace covis {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class CommandPlugins : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    images = render("mono", 3);
    write_video(images, folder / "video.avi", 10);
    io::WrittenBag bag(io::RosWire::ros1);
    io::RosCameraInfo info = io::camera_info();
    info.width = 96;
    info.height = 72;
    bag.add("/camera/camera_info", info);
    for (Timestamp stamp = 1; stamp < 4; ++stamp)
      bag.add_image("/camera/image_raw", stamp * 100'000'000, "mono8", std::string(96 * 72, 'g'), {96, 72});
    bag.write(folder / "recording.bag");
  }
  // Executes the command of this file.
  Outcome execute(const fs::path& file, const std::vector<std::string>& words) const {
    std::vector<std::string> all{file};
    all.insert(all.end(), words.begin(), words.end());
    Process process(all, folder / "stdout", folder / "stderr");
    const int code = process.wait(kPatience);
    return {code, text_of(folder / "stdout"), text_of(folder / "stderr")};
  }
  // The same; returns the names of the libraries that it loads.
  std::string loaded_by(const std::vector<std::string>& words) const {
    setenv("LD_DEBUG", "files", 1);
    setenv("LD_DEBUG_OUTPUT", (folder / "trace").c_str(), 1);  // and .PROCESS
    const Outcome outcome = execute(program, words);
    unsetenv("LD_DEBUG_OUTPUT");
    unsetenv("LD_DEBUG");
    EXPECT_EQ(outcome.code, 0) << words[0] << outcome.out << outcome.error;
    std::string names;
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (!entry.path().filename().string().starts_with("trace.")) continue;
      std::ifstream trace(entry.path());
      for (std::string line; std::getline(trace, line);) {
        if (const size_t at = line.find("calling init: "); at != std::string::npos)
          names += fs::path(line.substr(at)).filename().string() + "\n";
      }
      fs::remove(entry.path());
    }
    return names;
  }
  // Arguments that read an input of the folder.
  std::vector<std::string> check(const std::string& name) const {
    std::vector<std::string> words{"check", folder / name, "--out", folder / "check.png"};
    if (name != "recording.bag") words.insert(words.end(), {"--camera", images / "camera.yaml"});
    return words;
  }

  const fs::path program = fs::path(COVIS_COMMAND).parent_path() / "." / "covis";  // another name, so it is executed
  fs::path images;
};

TEST_F(CommandPlugins, AreOpenedByThatWhichNeedsThem) {
  const std::string version = loaded_by({"--version"}), of_images = loaded_by(check(images.filename())),
                    of_video = loaded_by(check("video.avi"));
  EXPECT_THAT(version, AllOf(HasSubstr("libopencv_core"), Not(HasSubstr("libopencv_imgcodecs"))));
  EXPECT_THAT(of_images, HasSubstr("libopencv_imgcodecs"));
  for (const std::string& libraries : {version, of_images}) {
    for (const char* other : {"libopencv_videoio", "libavcodec", "librosbag_storage", "libpython"})
      EXPECT_THAT(libraries, Not(HasSubstr(other)));
  }
  EXPECT_THAT(of_video, AllOf(HasSubstr("libopencv_videoio"), Not(HasSubstr("librosbag_storage"))));
  if (!io::reads_ros1_bags()) return;
  EXPECT_THAT(loaded_by(check("recording.bag")),
              AllOf(HasSubstr("librosbag_storage"), Not(HasSubstr("libopencv_videoio"))));
}

TEST_F(CommandPlugins, AreFoundBesideACopyAndNamedWithoutThem) {
  const fs::path copy = folder / "copy/covis";
  fs::create_directory(copy.parent_path());
  fs::copy_file(COVIS_COMMAND, copy);
  const auto expect_missing = [&](const std::string& name, const std::string& plugin) {
    const Outcome missing = execute(copy, check(name));
    EXPECT_EQ(missing.code, 1);
    EXPECT_THAT(missing.error, HasSubstr(plugin + ", which reads "));
    EXPECT_EQ(std::count(missing.error.begin(), missing.error.end(), '\n'), 1);
  };
  expect_missing(images.filename(), "covis_codecs.so");
  expect_missing("video.avi", "covis_video.so");
  if (io::reads_ros1_bags()) expect_missing("recording.bag", "covis_ros1_bag.so");
  // A video needs no codecs, but the pictures of its results do, which is an error before anything is tracked.
  fs::copy_file(fs::path(COVIS_BUILT_PLUGINS) / "covis_video.so", copy.parent_path() / "covis_video.so");
  const Outcome run =
      execute(copy, {"run", folder / "video.avi", "--camera", images / "camera.yaml", "--out", folder / "result"});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.error, HasSubstr("covis_codecs.so, which reads and writes compressed images"));
  EXPECT_FALSE(fs::exists(folder / "result"));
  for (const auto& plugin : fs::directory_iterator(COVIS_BUILT_PLUGINS)) {
    fs::copy_file(plugin, copy.parent_path() / plugin.path().filename(), fs::copy_options::overwrite_existing);
  }
  EXPECT_EQ(execute(copy, check(images.filename())).code, 0);
  EXPECT_EQ(execute(copy, check("video.avi")).code, 0);
}

TEST_F(CommandPlugins, AreOpenedWithinTheSandbox) {
  for (const std::string& name : {images.filename().string(), std::string("video.avi"), std::string("recording.bag")}) {
    if (name == "recording.bag" && !io::reads_ros1_bags()) continue;
    std::vector<std::string> words = check(name);
    words.insert(words.begin(), {"--sandbox", folder});
    const Outcome outcome = execute(program, words);
    if (outcome.error.find("--sandbox: ") != std::string::npos) GTEST_SKIP() << outcome.error;
    EXPECT_EQ(outcome.code, 0) << name << outcome.out << outcome.error;
  }
}

}  // namespace
}  // namespace covis
