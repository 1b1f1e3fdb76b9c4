// SPDX-License-Identifier: Apache-2.0
// The server of the viewer: HTTP for the page and for key frames' images, a WebSocket for what changes. It has one
// thread of low priority. Each client gets one message at a time, made when the last one has left, from what the client
// has to the newest state: a client that is slow gets fewer messages, and one that stalls for a minute is dropped.
//
// It listens on the loopback address unless another is asked for. Requests that a page of another site makes are
// refused, and so are those that come by a name that is not this machine's (DNS rebinding).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "apps/view/view_state.h"
#include "covis/core/error.h"

namespace covis::view {

// The things that the server shows. Only the server's thread calls it.
class ViewSource {
 public:
  virtual ~ViewSource() = default;
  // The state as it is now; it changes during this call alone. Called some times a second as long as there are clients.
  virtual const ViewState& refresh() = 0;
  // Called every second, also without clients.
  virtual void tidy() {}
  // The picture of a key frame as a file (JPEG or PNG); nothing: there is none.
  virtual std::optional<std::string> key_frame_image(const KeyFrameRow& key_frame) = 0;
};

struct ServerOptions {
  std::string host = "127.0.0.1";
  uint16_t port = 8642;  // 0: any that is free
  // Greatest time that one message may take to leave, seconds.
  int stall_seconds = 60;
};

class Server {
 public:
  // An error names the address that can't be listened on, and what would be right.
  static Result<std::unique_ptr<Server>> start(const ServerOptions& options, std::shared_ptr<ViewSource> source);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const;
  std::string url() const;
  // True when only this machine can reach it.
  bool local_only() const;
  // Number of pages that are connected.
  size_t clients() const;

 private:
  class Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace covis::view
