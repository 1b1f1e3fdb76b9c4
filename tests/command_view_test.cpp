// SPDX-License-Identifier: Apache-2.0
// covis view and covis run --view as people use them, without a browser: the address that they print, their end, and
// their messages where something is wrong. tests/viewer drives the page itself.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "command_results.h"

namespace covis {
namespace {

using testing::HasSubstr;

// A port of the loopback that is taken as long as this lives.
class TakenPort {
 public:
  TakenPort() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(socket_, 1), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    number = std::to_string(ntohs(address.sin_port));
  }
  ~TakenPort() { close(socket_); }
  TakenPort(const TakenPort&) = delete;
  TakenPort& operator=(const TakenPort&) = delete;

  std::string number;

 private:
  const int socket_;
};

class CommandView : public CommandTest {
 protected:
  void SetUp() override {
    CommandTest::SetUp();
    if (!COVIS_HAS_VIEWER) GTEST_SKIP() << "built without the viewer";
  }
};

TEST_F(CommandView, ServesAResultUntilCtrlC) {
  ASSERT_EQ(covis({"run", render("rgbd", 10), "--quiet", "--out", folder / "out"}).code, 0);
  Process process(command({"view", folder / "out", "--port", "0"}), folder / "stdout", folder / "stderr");
  while (text_of(folder / "stderr").find("until Ctrl-C") == std::string::npos && !process.ended())
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_THAT(text_of(folder / "stderr"), HasSubstr("http://127.0.0.1:"));
  process.send(SIGINT);
  EXPECT_EQ(process.wait(kPatience), 0);
}

TEST_F(CommandView, ARunThatIsShownGivesTheSameResult) {
  const fs::path recording = render("rgbd", 10);
  const Outcome plain = covis({"run", recording, "--quiet", "--out", folder / "plain"});
  const Outcome shown = covis({"run", recording, "--quiet", "--out", folder / "shown", "--view=0", "--view-close"});
  EXPECT_EQ(plain.code, 0);
  EXPECT_EQ(shown.code, 0) << shown.error;
  EXPECT_THAT(shown.error, HasSubstr("viewer: open http://127.0.0.1:"));
  EXPECT_EQ(text_of(folder / "plain" / "trajectory.txt"), text_of(folder / "shown" / "trajectory.txt"));
  EXPECT_EQ(text_of(folder / "plain" / "map.ply"), text_of(folder / "shown" / "map.ply"));
}

TEST_F(CommandView, OthersMayLookOnlyWhereThatIsAskedForAndIsWarnedOf) {
  const fs::path recording = render("rgbd", 5);
  const auto said = [&](const std::string& host) {
    const Outcome run =
        covis({"run", recording, "--out", folder / "out", "--view=0", "--view-host", host, "--view-close"});
    EXPECT_EQ(run.code, 0) << run.error;
    return run.error;
  };
  const std::string warning = "the viewer can be reached from other machines, without a password";
  EXPECT_THAT(said("0.0.0.0"), HasSubstr("0.0.0.0: " + warning));
  EXPECT_THAT(said("127.0.0.1"), testing::Not(HasSubstr(warning)));
}

TEST_F(CommandView, ATakenPortIsNamedAndNothingIsLost) {
  const TakenPort port;
  const fs::path recording = render("rgbd", 10);
  ASSERT_EQ(covis({"run", recording, "--quiet", "--out", folder / "out"}).code, 0);
  const std::string before = text_of(folder / "out" / "trajectory.txt");
  const Outcome run = covis({"run", recording, "--quiet", "--out", folder / "out", "--view=" + port.number});
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.error, HasSubstr("--view: port " + port.number + " of 127.0.0.1 is taken by another program"));
  EXPECT_EQ(text_of(folder / "out" / "trajectory.txt"), before);
  const Outcome view = covis({"view", folder / "out", "--port", port.number});
  EXPECT_EQ(view.code, 1);
  EXPECT_THAT(view.error, HasSubstr("is taken by another program; give another port, or 0"));
}

TEST_F(CommandView, WrongInputIsNamedWithWhatWouldBeRight) {
  const auto error = [&](const std::vector<std::string>& words, int code) {
    const Outcome outcome = covis(words);
    EXPECT_EQ(outcome.code, code);
    return outcome.error;
  };
  EXPECT_THAT(error({"view", folder / "none"}, 1), HasSubstr("there is no such file; give a result folder"));
  EXPECT_THAT(error({"view", folder}, 1), HasSubstr("it has no scene.bin"));
  EXPECT_THAT(error({"view", COVIS_COMMAND}, 1), HasSubstr(COVIS_COMMAND));
  EXPECT_THAT(error({"view", folder, "--port", "70000"}, 2), HasSubstr("65535"));
  EXPECT_THAT(error({"run", "x", "--view=70000"}, 2), HasSubstr("65535"));
  EXPECT_THAT(error({"run", "x", "--view=here"}, 2), HasSubstr("here"));
  ASSERT_EQ(covis({"run", render("rgbd", 10), "--quiet", "--out", folder / "out"}).code, 0);
  EXPECT_THAT(error({"view", folder / "out", "--port", "0", "--host", "nowhere"}, 1),
              HasSubstr("nowhere: it is no address"));
}

}  // namespace
}  // namespace covis
