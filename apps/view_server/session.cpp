// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/session.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/host_name.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <charconv>
#include <chrono>
#include <utility>

#include "apps/view/page.h"

namespace covis::view {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using ErrorCode = beast::error_code;

// Between two messages to a client, where it asks for no other.
constexpr std::chrono::milliseconds kInterval{66}, kLongestInterval{10'000};
// Until an image that is asked for is there; shorter than the time after which a source makes another.
constexpr std::chrono::milliseconds kImageTime{66};
constexpr size_t kMostQuestions = 64;        // that wait for their answers
constexpr size_t kMostRequestBytes = 16384;  // of a body, which no request that this server answers has, or a question
constexpr auto kIdle = std::chrono::seconds(60);  // a connection without a request ends

std::string text_of(beast::string_view text) { return {text.data(), text.size()}; }

// Names of hosts are the same in capitals, which browsers never send.
std::string lowered(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

// A host without its port: "localhost:80" is localhost, "[::1]:80" is ::1.
std::string without_port(std::string host) {
  if (host.starts_with('[')) {
    const size_t end = host.find(']');
    const bool whole = end != std::string::npos && (end + 1 == host.size() || host[end + 1] == ':');
    return whole ? host.substr(1, end - 1) : host;
  }
  return host.substr(0, host.find(':'));
}

// A host as a browser asks for it: an address, or this machine by its name. Any other name may be one that somebody
// lets lead here.
bool is_this_machine(const std::string& host, bool local_only) {
  const std::string name = without_port(host);
  if (name == "localhost") return true;
  ErrorCode not_an_address, unnamed;
  const auto address = boost::asio::ip::make_address(name, not_an_address);
  if (!not_an_address) return !local_only || address.is_loopback();
  return !local_only && is_name_of(boost::asio::ip::host_name(unnamed), name);
}

Response make(const Request& request, http::status status, const char* type, std::string body) {
  Response response{status, request.version()};
  response.set(http::field::content_type, type);
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Content-Security-Policy",
               "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' blob: data:; "
               "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  response.keep_alive(request.keep_alive());
  response.body() = request.method() == http::verb::head ? std::string() : std::move(body);
  response.prepare_payload();
  return response;
}

Response key_frame_image(const Request& request, const std::string& number, Shared& shared) {
  uint32_t id = 0;
  const auto parsed = std::from_chars(number.data(), number.data() + number.size(), id);
  const KeyFrameRow* row = parsed.ec == std::errc() && parsed.ptr == number.data() + number.size()
                               ? shared.source->refresh().map->key_frame(id)
                               : nullptr;
  auto picture = row ? shared.source->key_frame_image(*row) : std::nullopt;
  if (!picture) return make(request, http::status::not_found, "text/plain", "there is no image of this key frame\n");
  const char* type = picture->starts_with("\x89PNG") ? "image/png" : "image/jpeg";
  return make(request, http::status::ok, type, std::move(*picture));
}

}  // namespace

bool is_name_of(const std::string& machine, const std::string& asked) {
  const std::string whole = lowered(machine), name = lowered(asked);
  return !whole.empty() && (name == whole || name == whole.substr(0, whole.find('.')) + ".local");
}

std::string refusal(const Request& request, bool local_only) {
  const std::string host = lowered(text_of(request[http::field::host]));
  if (!is_this_machine(host, local_only)) {
    return local_only ? "this server is for this machine only: ask it as localhost\n"
                      : "ask this server by an address of its machine, or by the machine's name\n";
  }
  const std::string origin = lowered(text_of(request[http::field::origin]));
  if (!origin.empty() && origin != "http://" + host) return "a page of another site must not ask this server\n";
  return {};
}

Response respond(const Request& request, Shared& shared) {
  if (std::string why = refusal(request, shared.local_only); !why.empty())
    return make(request, http::status::forbidden, "text/plain", std::move(why));
  if (request.method() != http::verb::get && request.method() != http::verb::head)
    return make(request, http::status::method_not_allowed, "text/plain", "this server only answers GET\n");
  const std::string whole = text_of(request.target());
  const std::string target = whole.substr(0, whole.find('?'));
  if (target == "/") return make(request, http::status::ok, "text/html; charset=utf-8", std::string(page_html()));
  if (target == "/viewer.js") return make(request, http::status::ok, "text/javascript", std::string(page_script()));
  if (target == "/viewer.css") return make(request, http::status::ok, "text/css", std::string(page_style()));
  if (target == "/favicon.ico") return make(request, http::status::no_content, "text/plain", "");
  constexpr std::string_view kImages = "/key_frame/";
  if (target.starts_with(kImages)) return key_frame_image(request, target.substr(kImages.size()), shared);
  return make(request, http::status::not_found, "text/plain", "there is nothing here\n");
}

void HttpSession::read() {
  parser_.emplace();
  parser_->body_limit(kMostRequestBytes);
  stream_.expires_after(kIdle);
  http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](ErrorCode error, size_t) {
    if (error) return;
    self->request_ = self->parser_->release();
    self->handle();
  });
}

void HttpSession::handle() {
  if (!beast::websocket::is_upgrade(request_) || request_.target() != "/ws") return write(respond(request_, shared_));
  if (std::string why = refusal(request_, shared_.local_only); !why.empty())
    return write(make(request_, http::status::forbidden, "text/plain", std::move(why)));
  std::make_shared<SocketSession>(std::move(stream_), shared_)->accept(request_);
}

void HttpSession::write(Response response) {
  response_ = std::move(response);
  stream_.expires_after(kIdle);
  http::async_write(stream_, response_, [self = shared_from_this()](ErrorCode error, size_t) {
    if (error || self->response_.need_eof()) return;
    self->read();
  });
}

SocketSession::SocketSession(beast::tcp_stream stream, Shared& shared)
    : socket_(std::move(stream)),
      shared_(shared),
      interval_(kInterval),
      timer_(socket_.get_executor()),
      stall_(socket_.get_executor()) {
  ++shared_.clients;
}

void SocketSession::accept(const Request& request) {
  // Messages have time limits of their own (send()); a page that is gone closes its connection.
  beast::get_lowest_layer(socket_).expires_never();
  auto timeouts = beast::websocket::stream_base::timeout::suggested(beast::role_type::server);
  timeouts.keep_alive_pings = true;
  socket_.set_option(timeouts);
  socket_.read_message_max(kMostRequestBytes);
  socket_.binary(true);
  socket_.async_accept(request, [self = shared_from_this()](ErrorCode error) {
    if (error) return;
    self->read();
    self->send();
  });
}

void SocketSession::read() {
  socket_.async_read(question_, [self = shared_from_this()](ErrorCode error, size_t) {
    if (error) return self->drop();
    self->take_question(beast::buffers_to_string(self->question_.data()));
    self->question_.clear();
    self->read();
  });
}

void SocketSession::take_question(const std::string& question) {
  if (const auto interval = interval_in(question)) {
    interval_ = std::clamp(*interval, kInterval, kLongestInterval);
    return;
  }
  if (answers_.size() >= kMostQuestions) return;
  std::string reply = answer(shared_.source->refresh(), question);
  if (reply.empty()) return;
  answers_.push_back(std::move(reply));
  timer_.cancel();  // wakes send(), which otherwise looks after its interval
}

void SocketSession::send() {
  message_ = message_since(shared_.source->refresh(), sent_);
  for (; !answers_.empty(); answers_.pop_front()) message_ += answers_.front();
  if (message_.empty()) return wait_and_send();
  // A slow connection gets the time that it needs.
  constexpr size_t kSlow = 100'000;  // bytes a second
  stall_.expires_after(std::chrono::seconds(shared_.options.stall_seconds) +
                       std::chrono::seconds(message_.size() / kSlow));
  stall_.async_wait([self = shared_from_this()](ErrorCode error) {
    if (!error) self->drop();
  });
  socket_.async_write(boost::asio::buffer(message_), [self = shared_from_this()](ErrorCode error, size_t) {
    self->stall_.cancel();
    if (error) return self->drop();
    self->message_.clear();
    self->wait_and_send();
  });
}

void SocketSession::drop() {
  timer_.cancel();
  stall_.cancel();
  beast::get_lowest_layer(socket_).close();
}

void SocketSession::wait_and_send() {
  const auto then_send = [self = shared_from_this()](ErrorCode) {
    if (beast::get_lowest_layer(self->socket_).socket().is_open()) self->send();
  };
  // A question that came while a message was on its way does not wait for long.
  const auto interval = answers_.empty() ? interval_ : kInterval;
  if (interval <= kInterval + kImageTime) {
    timer_.expires_after(interval);
    return timer_.async_wait(then_send);
  }
  // The source is asked for an image before the message that is to have it.
  timer_.expires_after(interval - kImageTime);
  timer_.async_wait([self = shared_from_this(), then_send](ErrorCode error) {
    if (error) return then_send(error);
    self->shared_.source->refresh();
    self->timer_.expires_after(kImageTime);
    self->timer_.async_wait(then_send);
  });
}

}  // namespace covis::view
