// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/server.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <exception>
#include <string>
#include <thread>
#include <utility>

#include "apps/view_server/session.h"
#include "covis/core/log.h"
#include "covis/core/threads.h"

namespace covis::view {
namespace {

using boost::asio::ip::tcp;
using ErrorCode = boost::system::error_code;

constexpr size_t kMostConnections = 64, kMostClients = 16;

}  // namespace

class Server::Impl {
 public:
  Impl(const ServerOptions& options, std::shared_ptr<ViewSource> source) {
    shared_.source = std::move(source);
    shared_.options = options;
  }
  ~Impl() {
    context_.stop();
    if (thread_.joinable()) thread_.join();
  }

  Result<void> listen() {
    ErrorCode error;
    const auto address =
        boost::asio::ip::make_address(shared_.options.host == "localhost" ? "127.0.0.1" : shared_.options.host, error);
    if (error)
      return fail(shared_.options.host +
                  ": it is no address of this machine; for example 127.0.0.1, or 0.0.0.0 for all");
    shared_.local_only = address.is_loopback();
    const tcp::endpoint endpoint(address, shared_.options.port);
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(boost::asio::socket_base::max_listen_connections, error);
    if (error == boost::asio::error::address_in_use) {
      return fail("port " + std::to_string(endpoint.port()) + " of " + shared_.options.host +
                  " is taken by another program; give another port, or 0 for any that is free");
    }
    if (error)
      return fail("the viewer can't listen on " + shared_.options.host + " port " + std::to_string(endpoint.port()) +
                  ": " + error.message());
    accept();
    tidy();
    thread_ = std::jthread([this] {
      lower_thread_priority();
      while (!context_.stopped()) {
        try {
          context_.run();
        } catch (const std::exception& problem) {
          // The error is one connection's; the run and the other pages go on.
          log(LogLevel::warning, std::string("viewer: ") + problem.what());
        }
      }
    });
    return {};
  }

  const Shared& shared() const { return shared_; }
  tcp::endpoint endpoint() const { return acceptor_.local_endpoint(); }

 private:
  void accept() {
    acceptor_.async_accept([this](ErrorCode error, tcp::socket socket) {
      if (error == boost::asio::error::operation_aborted) return;
      // Those beyond the limits are closed at once.
      if (!error && shared_.connections < kMostConnections && shared_.clients < kMostClients)
        std::make_shared<HttpSession>(std::move(socket), shared_)->read();
      if (!error) return accept();
      // There may be no descriptor left for it, and none would be at once.
      accept_timer_.expires_after(std::chrono::milliseconds(200));
      accept_timer_.async_wait([this](ErrorCode ended) {
        if (!ended) accept();
      });
    });
  }

  void tidy() {
    tidy_timer_.expires_after(std::chrono::seconds(1));
    tidy_timer_.async_wait([this](ErrorCode error) {
      if (error) return;
      shared_.source->tidy();
      tidy();
    });
  }

  Shared shared_;
  boost::asio::io_context context_{1};
  tcp::acceptor acceptor_{context_};
  boost::asio::steady_timer tidy_timer_{context_}, accept_timer_{context_};
  std::jthread thread_;
};

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;

Result<std::unique_ptr<Server>> Server::start(const ServerOptions& options, std::shared_ptr<ViewSource> source) {
  auto impl = std::make_unique<Impl>(options, std::move(source));
  if (auto listening = impl->listen(); !listening) return tl::unexpected(listening.error());
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

uint16_t Server::port() const { return impl_->endpoint().port(); }

std::string Server::url() const {
  const auto address = impl_->endpoint().address();
  std::string host = address.to_string();
  if (address.is_unspecified()) host = "localhost";
  if (address.is_v6() && !address.is_unspecified()) host = "[" + host + "]";
  return "http://" + host + ":" + std::to_string(port()) + "/";
}

bool Server::local_only() const { return impl_->shared().local_only; }
size_t Server::clients() const { return impl_->shared().clients; }

}  // namespace covis::view
