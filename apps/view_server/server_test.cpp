// SPDX-License-Identifier: Apache-2.0
#include "apps/view_server/server.h"

#include <gmock/gmock.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <mutex>

#include "apps/view/page.h"
#include "apps/view/test_scene.h"
#include "apps/view_server/session.h"

namespace covis::view {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using boost::asio::ip::tcp;
using testing::HasSubstr;

// A state that the test's thread adds frames to.
class GrowingSource : public ViewSource {
 public:
  GrowingSource() {
    state_.info = "{}";
    state_.map = std::make_shared<const MapScene>(scene_of(small_snapshot()));
  }
  const ViewState& refresh() override {
    const std::lock_guard lock(mutex_);
    for (; added_ > 0; --added_) state_.log.add(FrameRow(), "");
    return state_;
  }
  std::optional<std::string> key_frame_image(const KeyFrameRow& key_frame) override {
    if (key_frame.id != 10) return std::nullopt;
    return "\x89PNG";
  }
  void add(int frames) {
    const std::lock_guard lock(mutex_);
    added_ += frames;
  }

 private:
  std::mutex mutex_;
  int added_ = 0;
  ViewState state_;
};

class ServerTest : public testing::Test {
 protected:
  ServerTest() {
    auto started = Server::start({.host = "127.0.0.1", .port = 0}, source);
    if (started) server = std::move(*started);
  }
  void SetUp() override { ASSERT_TRUE(server); }

  tcp::endpoint endpoint() const { return {boost::asio::ip::make_address("127.0.0.1"), server->port()}; }
  using Response = http::response<http::string_body>;
  using Fields = std::vector<std::pair<http::field, std::string>>;
  Response get(const std::string& target, const Fields& fields = {}, http::verb verb = http::verb::get,
               const std::string& body = "") {
    beast::tcp_stream stream(context);
    stream.connect(endpoint());
    http::request<http::string_body> request{verb, target, 11};
    request.set(http::field::host, "localhost:" + std::to_string(server->port()));
    for (const auto& [name, value] : fields) request.set(name, value);
    request.body() = body;
    request.prepare_payload();
    http::write(stream, request);
    beast::flat_buffer buffer;
    Response response;
    http::read(stream, buffer, response);
    return response;
  }

  using Socket = beast::websocket::stream<beast::tcp_stream>;
  std::unique_ptr<Socket> connect(const std::string& origin = "") {
    auto socket = std::make_unique<Socket>(context);
    beast::get_lowest_layer(*socket).connect(endpoint());
    if (!origin.empty()) {
      socket->set_option(beast::websocket::stream_base::decorator(
          [origin](beast::websocket::request_type& request) { request.set(http::field::origin, origin); }));
    }
    socket->read_message_max(0);
    socket->handshake("127.0.0.1:" + std::to_string(server->port()), "/ws");
    return socket;
  }
  static std::string read(Socket& socket) {
    beast::flat_buffer buffer;
    socket.read(buffer);
    return beast::buffers_to_string(buffer.data());
  }
  static std::vector<Block> kinds(const std::string& message) {
    std::vector<Block> list;
    const auto blocks = read_blocks(message);
    for (const ReadBlock& block : *blocks) list.push_back(block.kind);
    return list;
  }

  std::shared_ptr<GrowingSource> source = std::make_shared<GrowingSource>();
  std::unique_ptr<Server> server;
  boost::asio::io_context context;
};

TEST_F(ServerTest, ServesThePage) {
  const Response page = get("/");
  EXPECT_EQ(page.result(), http::status::ok);
  EXPECT_EQ(page.body(), page_html());
  EXPECT_EQ(page["Content-Security-Policy"].find("default-src 'none'"), 0u);
  EXPECT_EQ(get("/viewer.js").body(), page_script());
  EXPECT_EQ(get("/viewer.css").body(), page_style());
  EXPECT_EQ(get("/elsewhere").result(), http::status::not_found);
}

TEST_F(ServerTest, OnlyAnswersGet) {
  for (const char* body : {"", "a=1"})
    EXPECT_EQ(get("/", {}, http::verb::post, body).result(), http::status::method_not_allowed) << body;
}

TEST_F(ServerTest, ServesImagesOfKeyFramesThatHaveOne) {
  const Response image = get("/key_frame/10");
  EXPECT_EQ(image.result(), http::status::ok);
  EXPECT_EQ(image[http::field::content_type], "image/png");
  for (const char* none : {"/key_frame/15", "/key_frame/99", "/key_frame/", "/key_frame/1x", "/key_frame/-1"})
    EXPECT_EQ(get(none).result(), http::status::not_found) << none;
}

TEST_F(ServerTest, RefusesPagesOfOtherSitesAndForeignNames) {
  EXPECT_EQ(get("/", {{http::field::origin, "http://evil.example"}}).result(), http::status::forbidden);
  EXPECT_EQ(get("/", {{http::field::host, "evil.example"}}).result(), http::status::forbidden);
  for (const char* name :
       {"127.evil.example", "127.0.0.1.nip.io", "[::1].evil.example", "[::1", "0.0.0.0", "192.168.0.9"})
    EXPECT_EQ(get("/", {{http::field::host, name}}).result(), http::status::forbidden) << name;
  for (const char* name : {"localhost:80", "LocalHost", "127.0.0.1", "127.1.2.3:8642", "[::1]:80"})
    EXPECT_EQ(get("/", {{http::field::host, name}}).result(), http::status::ok) << name;
  EXPECT_THROW(connect("http://evil.example"), beast::system_error);
  EXPECT_NO_THROW(connect("http://127.0.0.1:" + std::to_string(server->port())));
}

TEST(ServerNames, TheMachineIsAskedByItsNameInAnyCaseOrAsLocal) {
  for (const char* name : {"Robot", "robot", "ROBOT", "robot.local", "Robot.Local"})
    EXPECT_TRUE(is_name_of("Robot", name)) << name;
  for (const char* name :
       {"", "rob", "robot.evil.example", "local", ".local", "robot.local.evil.example", "x.robot.local"})
    EXPECT_FALSE(is_name_of("Robot", name)) << name;
  EXPECT_TRUE(is_name_of("robot.site.example", "robot.local"));
  EXPECT_TRUE(is_name_of("robot.site.example", "Robot.Site.Example"));
  EXPECT_FALSE(is_name_of("robot.site.example", "robot.evil.example"));
  EXPECT_FALSE(is_name_of("", ".local"));
}

TEST(ServerNames, AServerOfTheNetworkAnswersToItsNameAndAddressesAlone) {
  const auto refused = [](const std::string& host, bool local_only) {
    Request request{http::verb::get, "/", 11};
    request.set(http::field::host, host);
    request.set(http::field::origin, "http://" + host);
    return !refusal(request, local_only).empty();
  };
  const std::string machine = boost::asio::ip::host_name();
  for (const std::string& host : {machine + ":8642", machine.substr(0, machine.find('.')) + ".local:8642"}) {
    EXPECT_FALSE(refused(host, false)) << host;
  }
  EXPECT_TRUE(refused("robot.local:8642", true));
  EXPECT_FALSE(refused("192.168.0.9:8642", false));
  EXPECT_TRUE(refused("evil.example:8642", false));
}

TEST_F(ServerTest, AClientGetsEverythingThenWhatChanges) {
  const auto socket = connect();
  EXPECT_THAT(kinds(read(*socket)), testing::Contains(Block::points));
  source->add(3);
  const std::string more = read(*socket);
  EXPECT_THAT(kinds(more), testing::Each(Block::frames));
  EXPECT_EQ(server->clients(), 1u);
}

TEST_F(ServerTest, QuestionsAreAnswered) {
  const auto socket = connect();
  read(*socket);
  socket->write(boost::asio::buffer(std::string(R"({"key_frame":15})")));
  EXPECT_THAT(kinds(read(*socket)), testing::ElementsAre(Block::key_frame_observations));
}

TEST_F(ServerTest, AClientThatAsksForFewerMessagesGetsWhatChangedInOne) {
  const auto spare = connect(), often = connect();
  read(*often);
  const auto ask = [&] {
    spare->write(boost::asio::buffer(std::string(R"({"key_frame":15})")));
    return read(*spare);
  };
  read(*spare);
  spare->write(boost::asio::buffer(std::string(R"({"interval":10000})")));
  ask();  // an answer comes at once, and the next message only after the interval
  for (int k = 0; k < 3; ++k) {
    source->add(1);
    read(*often);
  }
  const std::string message = ask();
  const auto blocks = read_blocks(message);
  ASSERT_THAT(kinds(message), testing::ElementsAre(Block::frames, Block::key_frame_observations));
  EXPECT_EQ(blocks->front().body.size(), 3 * sizeof(FrameRow));
}

TEST_F(ServerTest, AClientThatReadsNothingHoldsUpNobody) {
  const auto stalled = connect(), lively = connect();
  read(*lively);
  // More than the buffers of a connection hold.
  constexpr int kFrames = 500'000;
  source->add(kFrames);
  size_t received = 0;
  while (received < kFrames * sizeof(FrameRow)) {
    const std::string message = read(*lively);
    const auto blocks = read_blocks(message);
    for (const ReadBlock& block : *blocks) received += block.kind == Block::frames ? block.body.size() : 0;
  }
  source->add(1);
  EXPECT_THAT(kinds(read(*lively)), testing::Contains(Block::frames));
}

TEST_F(ServerTest, ATakenPortIsAnErrorThatNamesIt) {
  const auto second = Server::start({.host = "127.0.0.1", .port = server->port()}, source);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr("port " + std::to_string(server->port()) + " of 127.0.0.1 is taken"));
}

TEST_F(ServerTest, SaysWhereItListens) {
  EXPECT_EQ(server->url(), "http://127.0.0.1:" + std::to_string(server->port()) + "/");
  EXPECT_TRUE(server->local_only());
  const auto open = Server::start({.host = "0.0.0.0", .port = 0}, source);
  ASSERT_TRUE(open);
  EXPECT_FALSE((*open)->local_only());
  EXPECT_THAT(Server::start({.host = "nowhere", .port = 0}, source).error().message,
              HasSubstr("nowhere: it is no address"));
}

}  // namespace
}  // namespace covis::view
