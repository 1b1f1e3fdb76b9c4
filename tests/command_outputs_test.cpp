// SPDX-License-Identifier: Apache-2.0
// No command replaces what it reads, nor a file of another kind.
#include "command.h"

namespace covis {
namespace {

using testing::HasSubstr;

class CommandOutputs : public CommandTest {
 protected:
  static void SetUpTestSuite() { kept_ = fs::path(testing::TempDir()) / ("covis_outputs_" + std::to_string(getpid())); }
  static void TearDownTestSuite() { fs::remove_all(kept_); }

  void SetUp() override {
    CommandTest::SetUp();
    if (!fs::exists(kept_)) {
      const fs::path made = render("rgbd", 12);
      const Outcome run =
          covis({"run", made, "--quiet", "--keep-images", "--out", folder / "out", "--save-map", folder / "office.m"});
      ASSERT_EQ(run.code, 0) << run.error;
      fs::rename(made, folder / "rec");
      fs::copy(folder, kept_, fs::copy_options::recursive);
    } else {
      fs::copy(kept_, folder, fs::copy_options::recursive);
    }
    recording = folder / "rec";
    map = folder / "office.m";
    trajectory = folder / "out/trajectory.txt";
    truth = recording / "groundtruth.txt";
    image = fs::directory_iterator(recording / "rgb")->path();
    write("notes", "my notes\n");
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name, std::ios::binary) << text;
  }
  // The command must leave the file as it is and name it.
  void expect_kept(const fs::path& file, std::vector<std::string> words, const std::string& why) const {
    const std::string before = text_of(file);
    const Outcome refused = covis(words);
    EXPECT_EQ(refused.code, 1) << refused.out;
    EXPECT_THAT(refused.error, testing::AllOf(HasSubstr(file.filename().string() + ": "), HasSubstr(why)));
    EXPECT_TRUE(text_of(file) == before) << file << " was replaced";
  }
  void expect_given(const fs::path& file, const std::vector<std::string>& words) const {
    expect_kept(file, words, "left as they are");
  }
  void expect_foreign(const fs::path& file, const std::vector<std::string>& words) const {
    expect_kept(file, words, "it is there and is not ");
  }
  std::vector<std::string> run_to(const fs::path& out, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"run", recording, "--quiet", "--count", "4", "--out", out};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  fs::path recording, map, trajectory, truth, image;
  inline static fs::path kept_;
};

TEST_F(CommandOutputs, OfMapsReplaceNeitherTheMapNorOthers) {
  const auto to = [&](const std::string& format, const fs::path& out) {
    return std::vector<std::string>{"map", "export", map, "--to", format, "--out", out};
  };
  for (const char* format : {"ply", "tum", "kitti"}) {
    expect_given(map, to(format, map));
    expect_foreign(folder / "notes", to(format, folder / "notes"));
  }
  expect_foreign(recording / "camera.yaml", to("tum", recording / "camera.yaml"));
  std::vector<std::string> path = to("geojson", folder / "notes");
  path.insert(path.end(), {"--origin", "48", "11"});
  expect_foreign(folder / "notes", path);
  expect_given(map, {"map", "info", map, "--picture", map});
  expect_foreign(image, {"map", "info", map, "--picture", image});
  fs::create_directories(folder / "parts");
  fs::copy(map, folder / "parts/map0.m");
  expect_given(folder / "parts/map0.m", {"map", "split", folder / "parts/map0.m", "--out", folder / "parts"});
  fs::create_directories(folder / "areas");
  write("areas/area1.m", "my notes\n");
  expect_kept(folder / "areas/area1.m",
              {"map", "split", map, "--around", "0,0,0,100", "--around", "0,0,0,100", "--out", folder / "areas"},
              "is not a map");
  EXPECT_FALSE(fs::exists(folder / "areas/area0.m")) << "said before the first is saved";
  expect_foreign(folder / "notes", {"map", "import", folder, "--images", folder, "--out", folder / "notes"});
  for (const char* format : {"ply", "tum"}) {  // its own kind, twice
    EXPECT_EQ(covis(to(format, folder / format)).code, 0);
    EXPECT_EQ(covis(to(format, folder / format)).code, 0);
  }
  for (int twice = 0; twice < 2; ++twice)
    EXPECT_EQ(covis({"map", "info", map, "--picture", folder / "map.png"}).code, 0);
}

TEST_F(CommandOutputs, AnExportReplacesAnEarlierOneAlone) {
  for (const std::string format : {"colmap", "nerfstudio", "bundler"}) {
    const fs::path out = folder / format, other = folder / (format + "_of_others");
    const auto to = [&](const fs::path& where) {
      return covis({"map", "export", map, "--to", format, "--out", where});
    };
    EXPECT_EQ(to(out).code, 0);
    EXPECT_EQ(to(out).code, 0) << "its own";
    fs::create_directories(other / "images");
    EXPECT_EQ(to(fs::path(other / "images")).code, 0) << "an empty folder";
    fs::remove_all(other / "images");
    fs::create_directories(other / "images");
    fs::copy(image, other / "images/000000.png");
    const Outcome refused = to(other);
    EXPECT_EQ(refused.code, 1);
    EXPECT_THAT(refused.error, HasSubstr("the folder holds other things"));
    EXPECT_EQ(text_of(other / "images/000000.png"), text_of(image));
  }
  fs::create_directories(folder / "of_colmap/sparse/0");
  write("of_colmap/sparse/0/cameras.txt", "# Camera list with one line of data per camera:\n");
  expect_foreign(folder / "of_colmap/sparse/0/cameras.txt",
                 {"map", "export", map, "--to", "colmap", "--out", folder / "of_colmap"});
}

TEST_F(CommandOutputs, OfARunReplaceThoseOfARun) {
  EXPECT_EQ(covis(run_to(folder / "out")).code, 0) << "results by results";
  for (const char* name : {"trajectory.txt", "trajectory_online.txt", "keyframes.txt", "map.ply", "stats.jsonl",
                           "summary.json", "scene.bin", "report.html", "trajectory.png"}) {
    fs::create_directories(folder / "mine");
    write(std::string("mine/") + name, "my notes\n");
    expect_foreign(folder / "mine" / name, run_to(folder / "mine"));
    fs::remove_all(folder / "mine");
  }
  fs::create_directories(folder / "mine");
  write("mine/trajectory_map3.txt", "my notes\n");
  expect_foreign(folder / "mine/trajectory_map3.txt", run_to(folder / "mine"));
  EXPECT_FALSE(fs::exists(folder / "mine/trajectory.txt")) << "said before the run";
  const fs::path fresh = folder / "new";
  expect_given(fresh / "trajectory.txt", run_to(fresh, {"--save-map", fresh / "trajectory.txt"}));
  fs::copy(recording / "camera.yaml", fresh / "keyframes.txt");
  expect_given(fresh / "keyframes.txt", run_to(fresh, {"--camera", fresh / "keyframes.txt"}));
}

TEST_F(CommandOutputs, OfLocalizeEvalAndCheckReplaceNeitherInputsNorOthers) {
  const auto localize = [&](const fs::path& out) {
    return std::vector<std::string>{"localize", recording, "--count", "2", "--map", map, "--out", out};
  };
  expect_given(map, localize(map));
  expect_given(truth, localize(truth));
  expect_foreign(image, localize(image));
  EXPECT_EQ(covis(localize(trajectory)).code, 0) << "a trajectory by another";
  const auto eval = [&](const fs::path& plot) {
    return std::vector<std::string>{"eval", trajectory, truth, "--plot", plot};
  };
  fs::copy(truth, folder / "truth.png");
  expect_given(folder / "truth.png", {"eval", trajectory, folder / "truth.png", "--plot", folder / "truth.png"});
  expect_foreign(image, eval(image));
  write("page.html", "<html>mine</html>\n");
  expect_foreign(folder / "page.html", eval(folder / "page.html"));
  for (const char* plot : {"own.png", "own.html", "own.png", "own.html"})
    EXPECT_EQ(covis({"eval", recording / "groundtruth.txt", truth, "--plot", folder / plot}).code, 0);
  const auto check = [&](const fs::path& out) {
    return std::vector<std::string>{"check", recording, "--count", "2", "--out", out};
  };
  expect_foreign(image, check(image));
  expect_foreign(map, check(map));
  for (int twice = 0; twice < 2; ++twice) EXPECT_EQ(covis(check(folder / "own.png")).code, 0);
}

TEST_F(CommandOutputs, DefaultNamesReplaceWhatCovisMadeAlone) {
  const fs::path before = fs::current_path();
  fs::current_path(folder);
  fs::copy(image, folder / "check.png");
  expect_foreign(folder / "check.png", {"check", recording, "--count", "2"});
  fs::remove(folder / "check.png");
  for (int twice = 0; twice < 2; ++twice) EXPECT_EQ(covis({"check", recording, "--count", "2"}).code, 0);
  const fs::path own = folder / "camera.yaml";
  write(
      "opencv.yaml",
      "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n"
      "   dt: d\n   data: [ 500., 0., 320., 0., 500., 240., 0., 0., 1. ]\n"
      "distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ 0., 0., 0., 0., 0. ]\n");
  write("camera.yaml", "# mine\nlens: wide\n");
  expect_foreign(own, {"check", "--import-camera", "opencv.yaml"});
  expect_given(folder / "opencv.yaml", {"check", "--import-camera", "opencv.yaml", "--out", "opencv.yaml"});
  expect_foreign(map, {"check", "--import-camera", "opencv.yaml", "--out", "office.m"});
  fs::remove(own);
  for (int twice = 0; twice < 2; ++twice) {
    const Outcome imported = covis({"check", "--import-camera", "opencv.yaml"});
    EXPECT_EQ(imported.code, 0) << imported.error;
  }
  write("camera.yaml", "# mine\nwidth: 640\nheight: 480\nfx: 500\nfy: 500\ncx: 320\ncy: 240\nfps: 30\n");
  expect_foreign(own, {"check", "--import-camera", "opencv.yaml"});
  expect_foreign(own, {"calibrate", recording / "rgb", "--board", "9x6", "--square", "0.02"});
  fs::remove(own);
  expect_foreign(map, {"calibrate", recording / "rgb", "--board", "9x6", "--square", "0.02", "--picture", map});
  fs::current_path(before);
}

TEST_F(CommandOutputs, VocabulariesReplaceVocabulariesAlone) {
  const auto train = [&](const fs::path& out) {
    return std::vector<std::string>{"vocab", "train",   recording / "rgb", "--branching", "4", "--depth",
                                    "2",     "--quiet", "--overwrite",     "--out",       out};
  };
  expect_foreign(map, train(map));
  // Depth images and links that lead nowhere are passed over.
  const auto images = std::distance(fs::directory_iterator(recording / "rgb"), fs::directory_iterator());
  fs::copy(recording / "depth", recording / "rgb/aligned_depth");
  fs::create_symlink(recording / "rgb/loop.png", recording / "rgb/loop.png");
  for (int twice = 0; twice < 2; ++twice) {
    std::vector<std::string> loudly = train(folder / "v");
    std::erase(loudly, "--quiet");
    const Outcome trained = covis(loudly);
    EXPECT_EQ(trained.code, 0) << trained.error;
    EXPECT_THAT(trained.out, testing::StartsWith(std::to_string(images) + " images "));
  }
  fs::remove_all(recording / "rgb/aligned_depth");
  fs::remove(recording / "rgb/loop.png");
  const auto convert = [&](const fs::path& out) {
    return std::vector<std::string>{"vocab", "convert", folder / "v", out, "--overwrite"};
  };
  expect_foreign(map, convert(map));
  expect_given(folder / "v", convert(folder / "v"));
  for (int twice = 0; twice < 2; ++twice) EXPECT_EQ(covis(convert(folder / "v.txt")).code, 0);
}

}  // namespace
}  // namespace covis
