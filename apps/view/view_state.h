// SPDX-License-Identifier: Apache-2.0
// The state that a viewer shows, and the message that brings a client from what it has to that state: only what changed
// is in it.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/view/map_scene.h"
#include "apps/view/protocol.h"
#include "apps/view/run_log.h"

namespace covis::view {

// The newest image of a run, encoded.
struct ViewImage {
  int32_t frame = -1;  // -1: there is none
  uint32_t width = 0, height = 0;
  std::vector<KeypointRow> keypoints;
  std::string jpeg;
};

struct ViewState {
  std::string info;           // JSON for the page
  uint64_t info_version = 1;  // rises when info changes; the page then begins its lists of the log anew
  std::shared_ptr<const MapScene> map = std::make_shared<MapScene>();
  RunLog log;
  ViewImage image;
};

// How much of a state a client has.
struct Sent {
  uint64_t info_version = 0;
  std::shared_ptr<const MapScene> map = std::make_shared<MapScene>();
  size_t frames = 0, texts = 0;
  std::vector<uint32_t> loop_versions;
  int32_t image = -1;
};

// The client has all of `state` once it has this message; empty when it had it before.
std::string message_since(const ViewState& state, Sent& sent);

// The answer to what a page asks: JSON {"key_frame": ID} or {"point": ID}, for its observations. Empty: the question
// makes no sense.
std::string answer(const ViewState& state, std::string_view question);
// The time between two messages that a page asks for, JSON {"interval": MILLISECONDS}; nothing: it asks something else.
std::optional<std::chrono::milliseconds> interval_in(std::string_view question);

// The whole state, with all observations: the content of the file of a finished run.
std::string file_of(const ViewState& state);
// An error says what is wrong with the bytes.
Result<ViewState> state_of_file(std::string_view bytes);

}  // namespace covis::view
