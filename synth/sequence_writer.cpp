// SPDX-License-Identifier: Apache-2.0
#include "synth/sequence_writer.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>
#include <thread>
#include <vector>

#include "covis/core/atomic_file.h"
#include "covis/core/blocking_queue.h"
#include "covis/io/camera_file.h"
#include "covis/io/codecs.h"
#include "covis/io/files.h"
#include "covis/io/trajectory.h"

namespace covis {
namespace {

namespace fs = std::filesystem;

constexpr size_t kQueued = 6;  // greatest number of images waiting to be encoded

std::string format(const char* pattern, auto... values) {
  std::array<char, 512> text;
  const int length = std::snprintf(text.data(), text.size(), pattern, values...);
  return {text.data(), static_cast<size_t>(length)};
}

// Encodes images as PNG and writes them, in a thread of its own. The first error stops it.
class ImageWriter {
 public:
  ImageWriter() : queue_(kQueued), thread_([this] { run(); }) {}
  ~ImageWriter() { queue_.close(); }  // the thread is joined by its own destructor

  // Returns false once an image could not be written.
  bool write(fs::path file, cv::Mat image) { return queue_.push({std::move(file), std::move(image)}); }
  // Waits until all images are written; returns the number of bytes.
  Result<uint64_t> finish() {
    queue_.close();
    thread_.join();
    if (error_) return tl::unexpected(*error_);
    return bytes_;
  }

 private:
  struct Job {
    fs::path file;
    cv::Mat image;
  };
  void run() {
    while (auto job = queue_.pop()) {
      // Fast to write and to read, and for grey images no larger than with a search for matches.
      const auto coded = io::encode_image(
          ".png", job->image,
          {cv::IMWRITE_PNG_COMPRESSION, 1, cv::IMWRITE_PNG_STRATEGY, cv::IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY});
      if (!coded) {
        error_ = Error{job->file.string() + ": " + coded.error().message};
      } else if (auto ok = write_atomically(job->file, *coded); !ok) {
        error_ = ok.error();
      }
      if (error_) {
        queue_.close();
        return;
      }
      bytes_ += coded->size();
    }
  }

  BlockingQueue<Job> queue_;
  std::optional<Error> error_;  // read after the thread has ended
  uint64_t bytes_ = 0;
  std::jthread thread_;
};

cv::Mat copy(const ImageU8& image) {
  cv::Mat mat(image.height(), image.width(), CV_8U);
  for (int y = 0; y < image.height(); ++y) std::memcpy(mat.ptr(y), image.row(y), static_cast<size_t>(image.width()));
  return mat;
}

// Depths that do not fit 16 bits are stored as 0 (no measurement).
cv::Mat depth_image(const ImageF& depth, double scale) {
  cv::Mat mat(depth.height(), depth.width(), CV_16U);
  for (int y = 0; y < depth.height(); ++y) {
    uint16_t* to = mat.ptr<uint16_t>(y);
    for (int x = 0; x < depth.width(); ++x) {
      const double units = std::round(scale * static_cast<double>(depth(x, y)));
      to[x] = units > 0 && units < 65536 ? static_cast<uint16_t>(units) : uint16_t{0};
    }
  }
  return mat;
}

// Lies in every recording that is made here, before anything else does: another one is never replaced.
constexpr const char* kMark = "synth.json";
constexpr std::string_view kMarkBegins = "{\"made_by\": \"covis synth\"";

std::string mark_of(const SynthOptions& o) {
  std::string text(kMarkBegins);
  text += format(R"(, "world": "%s", "sensor": "%s", "seed": %d})", o.world.c_str(), o.sensor.c_str(), o.seed);
  return text += '\n';
}

bool is_marked(const fs::path& folder) {
  const auto head = io::read_head(folder / kMark, kMarkBegins.size());
  return head && *head == kMarkBegins;
}

Result<void> prepare_folder(const fs::path& folder, Existing existing, const std::vector<std::string>& subfolders) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder))
    return fail("folder " + folder.string() + " can't be made: " + (error ? error.message() : "it is a file"));
  if (!fs::is_empty(folder, error)) {
    if (existing == Existing::refuse)
      return fail("folder " + folder.string() + " is not empty; choose another, or say --overwrite");
    if (!is_marked(folder))
      return fail("folder " + folder.string() +
                  " is not empty, and covis synth did not make what is in it (it has no " + kMark +
                  "), so that it is not replaced; choose another folder");
    for (const char* ours : {"rgb", "depth", "images", "image_0", "image_1", "rgb.txt", "depth.txt", "associations.txt",
                             "groundtruth.txt", "camera.yaml", "calib.txt", "times.txt", "poses.txt"}) {
      fs::remove_all(folder / ours, error);
      if (error) return fail((folder / ours).string() + " can't be removed: " + error.message());
    }
  }
  for (const std::string& name : subfolders) {
    fs::create_directories(folder / name, error);
    if (error) return fail("folder " + (folder / name).string() + " can't be made: " + error.message());
  }
  return {};
}

std::string camera_yaml(const Synth& synth) {
  io::CameraFile file;
  file.camera = synth.camera();
  file.fps = synth.options().fps;
  if (synth.sensor() == Sensor::rgbd) {
    file.baseline = synth.camera().pinhole.baseline();
    file.depth_scale = synth.depth_units();
  }
  return io::camera_text(file);
}

// Writes the files that describe the images.
Result<void> write_description(const Synth& synth, const fs::path& folder, const Trajectory& truth) {
  std::string rgb = "# stamp file\n", depth = rgb, pairs = "# stamp image stamp depth\n", times;
  for (const StampedPose& pose : truth) {
    const std::string stamp = io::stamp_text(pose.stamp);
    rgb += stamp + " rgb/" + stamp + ".png\n";
    depth += stamp + " depth/" + stamp + ".png\n";
    pairs += stamp + " rgb/" + stamp + ".png " + stamp + " depth/" + stamp + ".png\n";
    times += stamp + "\n";
  }
  const Pinhole& k = synth.camera().pinhole;
  std::vector<std::pair<std::string, std::string>> files;
  switch (synth.sensor()) {
    case Sensor::rgbd:
      files = {
          {"rgb.txt", rgb}, {"depth.txt", depth}, {"associations.txt", pairs}, {"camera.yaml", camera_yaml(synth)}};
      break;
    case Sensor::monocular:
      files = {{"times.txt", times}, {"camera.yaml", camera_yaml(synth)}};
      break;
    case Sensor::stereo: {
      std::string calibration;
      for (int camera = 0; camera < 2; ++camera) {
        calibration += format("P%d: %.12e 0 %.12e %.12e 0 %.12e %.12e 0 0 0 1 0\n", camera, k.fx, k.cx,
                              camera ? -k.bf : 0.0, k.fy, k.cy);
      }
      files = {{"times.txt", times}, {"calib.txt", calibration}};
    }
  }
  for (const auto& [name, text] : files) {
    if (auto ok = write_atomically(folder / name, text); !ok) return ok;
  }
  if (auto ok = io::write_trajectory(folder / "groundtruth.txt", truth, io::TrajectoryFormat::tum); !ok) return ok;
  if (synth.sensor() != Sensor::stereo) return {};
  // KITTI's poses are given in the frame of the first camera.
  Trajectory relative = truth;
  for (StampedPose& pose : relative) pose.T_wc = truth.front().T_wc.inverse() * pose.T_wc;
  return io::write_trajectory(folder / "poses.txt", relative, io::TrajectoryFormat::kitti);
}

}  // namespace

Result<SynthReport> write_sequence(Synth& synth, const fs::path& folder, Existing existing,
                                   const std::function<bool(int)>& progress) {
  const Sensor sensor = synth.sensor();
  const std::vector<std::string> subfolders = sensor == Sensor::rgbd ? std::vector<std::string>{"rgb", "depth"}
                                              : sensor == Sensor::stereo
                                                  ? std::vector<std::string>{"image_0", "image_1"}
                                                  : std::vector<std::string>{"images"};
  if (auto ok = prepare_folder(folder, existing, subfolders); !ok) return tl::unexpected(ok.error());
  if (auto ok = write_atomically(folder / kMark, mark_of(synth.options())); !ok) return tl::unexpected(ok.error());
  SynthReport report;
  Trajectory truth;
  for (int i = 0; i < synth.frames(); ++i) {
    truth.push_back({synth.stamp(i), synth.T_wc(i)});
    if (i > 0) report.path_metres += (truth.back().T_wc.t() - truth[truth.size() - 2].T_wc.t()).norm();
  }
  if (auto ok = write_description(synth, folder, truth); !ok) return tl::unexpected(ok.error());

  ImageWriter writer;
  ImageU8 left, right;
  ImageF depth;
  for (int i = 0; i < synth.frames(); ++i) {
    synth.render(i, left, sensor == Sensor::stereo ? &right : nullptr, sensor == Sensor::rgbd ? &depth : nullptr);
    const std::string name = sensor == Sensor::rgbd ? io::stamp_text(synth.stamp(i)) + ".png" : format("%06d.png", i);
    bool ok = writer.write(folder / subfolders[0] / name, copy(left));
    if (sensor == Sensor::stereo) ok = ok && writer.write(folder / subfolders[1] / name, copy(right));
    if (sensor == Sensor::rgbd)
      ok = ok && writer.write(folder / subfolders[1] / name, depth_image(depth, synth.depth_units()));
    if (!ok) break;  // finish() returns the error
    report.frames = i + 1;
    if (progress && !progress(report.frames)) {
      return fail("stopped after " + std::to_string(report.frames) + " of " + std::to_string(synth.frames()) +
                  " frames; " + folder.string() + " is not complete");
    }
  }
  const auto bytes = writer.finish();
  if (!bytes) return tl::unexpected(bytes.error());
  report.bytes = *bytes;
  return report;
}

}  // namespace covis
