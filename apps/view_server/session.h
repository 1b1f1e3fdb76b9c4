// SPDX-License-Identifier: Apache-2.0
// One connection of a browser: HTTP requests, and the WebSocket that one of them may ask for.
#pragma once

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "apps/view_server/server.h"

namespace covis::view {

// The state that all connections of a server share; the server's thread alone uses it, but for `clients`.
struct Shared {
  std::shared_ptr<ViewSource> source;
  ServerOptions options;
  bool local_only = true;
  std::atomic<size_t> clients{0};
  size_t connections = 0;  // that ask for pages and images
};

using Request = boost::beast::http::request<boost::beast::http::string_body>;
using Response = boost::beast::http::response<boost::beast::http::string_body>;

// The answer to a request that is not for the WebSocket.
Response respond(const Request& request, Shared& shared);
// Empty when the request may be answered, else why not. The Host must be an address or name of the loopback when the
// server is for this machine only, and a page that asks must be this server's.
std::string refusal(const Request& request, bool local_only);
// The name of a machine, or that by which its own network finds it (NAME.local, RFC 6762), in any case of letters.
bool is_name_of(const std::string& machine, const std::string& asked);

// Lives as long as an operation of it is pending.
class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(boost::asio::ip::tcp::socket socket, Shared& shared) : stream_(std::move(socket)), shared_(shared) {
    ++shared_.connections;
  }
  ~HttpSession() { --shared_.connections; }
  void read();

 private:
  void handle();
  void write(Response response);

  boost::beast::tcp_stream stream_;
  Shared& shared_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  Request request_;
  Response response_;
};

class SocketSession : public std::enable_shared_from_this<SocketSession> {
 public:
  SocketSession(boost::beast::tcp_stream stream, Shared& shared);
  ~SocketSession() { --shared_.clients; }
  void accept(const Request& request);

 private:
  void read();
  void take_question(const std::string& question);
  // Sends what the client lacks or asked for, unless a message is on its way; looks again after a while.
  void send();
  void wait_and_send();
  void drop();

  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  Shared& shared_;
  boost::beast::flat_buffer question_;
  std::deque<std::string> answers_;
  Sent sent_;
  std::chrono::milliseconds interval_;  // between two messages
  std::string message_;                 // on its way; empty: none
  boost::asio::steady_timer timer_;     // until the next look
  boost::asio::steady_timer stall_;     // until a message on its way has taken too long
};

}  // namespace covis::view
