// SPDX-License-Identifier: Apache-2.0
#include "common.h"

#include "covis/core/log.h"

namespace covis::app {
namespace {

void on_signal(int signal) {
  interrupted = signal;
  std::signal(signal, SIG_DFL);
}

}  // namespace

const std::map<std::string, Sensor> kSensors{
    {"mono", Sensor::monocular}, {"stereo", Sensor::stereo}, {"rgbd", Sensor::rgbd}};

const std::map<std::string, io::SequenceKind> kKinds{
    {"tum", io::SequenceKind::tum},       {"kitti", io::SequenceKind::kitti}, {"euroc", io::SequenceKind::euroc},
    {"images", io::SequenceKind::images}, {"video", io::SequenceKind::video}, {"camera", io::SequenceKind::camera}};

volatile std::sig_atomic_t interrupted = 0;

nlohmann::json camera_json(const Camera& camera) {
  static constexpr const char* kModels[] = {"pinhole", "brown_conrady", "kannala_brandt"};
  nlohmann::json json{{"width", camera.width},
                      {"height", camera.height},
                      {"fx", camera.pinhole.fx},
                      {"fy", camera.pinhole.fy},
                      {"cx", camera.pinhole.cx},
                      {"cy", camera.pinhole.cy},
                      {"model", kModels[static_cast<int>(camera.distortion)]}};
  if (camera.pinhole.bf > 0) json["baseline"] = camera.pinhole.baseline();
  if (camera.distortion != Distortion::none) json["distortion"] = camera.coefficients;
  return json;
}

int fail_with(const std::string& message) {
  log(LogLevel::error, message);
  return 1;
}

int fail_with(const Error& error) { return fail_with(error.message); }

void end_well_on_signals() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

}  // namespace covis::app
