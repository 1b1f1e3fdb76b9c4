// SPDX-License-Identifier: Apache-2.0
// Pages that stall or leave while a run goes on: its results have the bytes of a run that nobody looks at. The clients
// come and go between two frames, on the tracking thread, so that nothing depends on time.
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "apps/run/run_loop.h"
#include "apps/run/run_outputs.h"
#include "apps/view_server/live_view.h"
#include "apps/view_server/server.h"
#include "covis/core/test_folder.h"
#include "covis/io/sequence.h"
#include "rendered.h"
#include "synth/sequence_writer.h"

namespace covis {
namespace {

// A connection as that of a page, which reads when the test says so alone.
class Client {
 public:
  explicit Client(uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    EXPECT_EQ(connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    const std::string request =
        "GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n";
    EXPECT_EQ(send(socket_, request.data(), request.size(), 0), static_cast<ssize_t>(request.size()));
  }
  ~Client() { close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  // Returns once so many bytes have come.
  void read(size_t bytes) const {
    std::string buffer(bytes, '\0');
    EXPECT_EQ(recv(socket_, buffer.data(), bytes, MSG_WAITALL), static_cast<ssize_t>(bytes));
  }

 private:
  const int socket_;
};

// Lets clients come before the first frame; one leaves after the sixth, in the middle of a message.
class Visited : public app::RunObserver {
 public:
  // The frames that were skipped before: more than the buffers of a connection hold, so that a message to somebody who
  // does not read it stays on its way.
  static constexpr int kSkipped = 200'000;

  Visited() : server_(view::Server::start({.host = "127.0.0.1", .port = 0, .stall_seconds = 3600}, live_).value()) {}

  void run_begins(const System& system) override {
    live_->run_begins(system);
    for (int k = 0; k < kSkipped; ++k) live_->frame_skipped(app::skipped_frame(k, 0, app::FrameState::late, "late"));
    stalls_.emplace(server_->port());
    leaves_.emplace(server_->port());
    wait_for_clients(2);
  }
  void frame_tracked(const app::FrameStats& stats, const io::Frame& frame, const FrameReport& report) override {
    live_->frame_tracked(stats, frame, report);
    if (frame.index != 5) return;
    leaves_->read(100'000);
    leaves_.reset();
    wait_for_clients(1);
  }
  void frame_skipped(const app::FrameStats&) override {}
  void loops_changed(const std::vector<view::LoopPaths>& loops) override { live_->loops_changed(loops); }
  void run_ended() {
    live_->run_ended({});
    EXPECT_EQ(server_->clients(), 1u) << "the one that reads nothing is still there";
  }

 private:
  void wait_for_clients(size_t count) const {
    while (server_->clients() != count) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  std::shared_ptr<view::LiveView> live_ = std::make_shared<view::LiveView>("{}");
  std::unique_ptr<view::Server> server_;
  std::optional<Client> stalls_, leaves_;
};

class ViewedRun : public testing::Test {
 protected:
  void SetUp() override {
    auto synth = Synth::create({.world = "desk", .frames = 15, .fps = 10, .width = 320, .height = 240});
    ASSERT_TRUE(write_sequence(synth.value(), folder / "desk", Existing::refuse, {}));
  }
  void run(const std::string& out, Visited* visited) const {
    auto sequence = io::open_sequence(folder / "desk", {});
    ASSERT_TRUE(sequence) << sequence.error().message;
    const std::atomic<int> stop = 0;
    app::PlayOptions play;
    play.stop = &stop;
    play.observer = visited;
    play.show_progress = false;
    app::RunRecord record;
    System system((*sequence)->camera(), options_for(Sensor::rgbd), vocabulary());
    app::track_all(**sequence, system, play, record);
    if (visited) visited->run_ended();
    const auto snapshot = system.snapshot();
    const app::RunSummary summary = app::summarise(record, *snapshot, nullptr, 0);
    EXPECT_EQ(summary.frames.all, 15u);
    std::filesystem::create_directory(folder / out);
    ASSERT_TRUE(app::write_outputs(record, *snapshot, summary, {.directory = folder / out, .title = out}));
  }

  const TemporaryFolder folder;
};

TEST_F(ViewedRun, HasTheSameBytesWithClientsThatStallAndLeave) {
  run("alone", nullptr);
  Visited visited;
  run("visited", &visited);
  for (const char* file : {"trajectory.txt", "trajectory_online.txt", "keyframes.txt", "map.ply"}) {
    const std::string alone = read_file(folder / "alone" / file);
    EXPECT_GT(alone.size(), 200u) << file;
    EXPECT_TRUE(alone == read_file(folder / "visited" / file)) << file;
  }
}

}  // namespace
}  // namespace covis
