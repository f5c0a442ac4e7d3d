#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fmt/format.h>
#include <future>
#include <gtest/gtest.h>
#include <latch>
#include <list>
#include <stdexcept>
#include <string>
#include <thread>
#include <unistd.h>

#include "core/input_error.hpp"
#include "server/serve.hpp"
#include "tests/web_client.hpp"

namespace livermark::server {
namespace {

namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;
using tests::own_origin;
using tests::status_of;
using tests::upgrade;
using tests::WebSocketClient;
using namespace std::chrono_literals;

constexpr auto *target_of_echo = "/echo?name=a%20b";

/// Says everything again, and what it was begun with in front of texts. The reply to "wait" comes when somebody has
/// said "go on"; either may be said once.
struct Echo {
    std::latch is_waiting{1};
    std::latch goes_on{1};
    Conversation begin(const Fields &query);
};

Conversation Echo::begin(const Fields &query) {
    const auto name = required_text(query, "name");
    return [this, name](const Message &message) -> Message {
        if (message.bytes == "fault")
            throw core::InputError("50 % of a & b: say something else");
        if (message.bytes == "break")
            throw std::runtime_error("broken on purpose");
        if (message.bytes == "wait") {
            is_waiting.count_down();
            goes_on.wait();
        }
        if (message.bytes == "go on")
            goes_on.count_down();
        return {message.is_binary, message.is_binary ? message.bytes : name + ": " + message.bytes};
    };
}

/// serve() in a thread, until the signal that Ctrl-C sends.
class Served {
  public:
    Served() {
        std::promise<std::uint16_t> is_ready;
        auto port_in_future = is_ready.get_future();
        thread_ = std::thread([this, is_ready = std::move(is_ready)]() mutable {
            Site site{.folder = "/nowhere",
                      .page = "/nowhere/index.html",
                      .port = 0,
                      .is_result_file = {},
                      .conversations = {{"/echo", [this](const Fields &query) { return echo.begin(query); }}}};
            serve(std::move(site), [&](std::uint16_t port) { is_ready.set_value(port); });
        });
        port = port_in_future.get();
    }
    ~Served() { stop(); }
    void stop() {
        if (!thread_.joinable())
            return;
        kill(getpid(), SIGINT);
        thread_.join();
    }

    std::uint16_t port = 0;
    Echo echo;

  private:
    std::thread thread_;
};

int status_of_upgrade(std::uint16_t port, const std::string &target = target_of_echo) {
    return status_of(upgrade(port, target), port);
}

TEST(Sockets, ReplyToEveryMessageInItsKind) {
    const Served served;
    WebSocketClient client(served.port);
    ASSERT_TRUE(client.open(target_of_echo));
    EXPECT_EQ(client.reply_to("one"), "a b: one");
    EXPECT_EQ(client.reply_to(""), "a b: ");
    const std::string large(3 << 20, '\xff');
    client.send(large, true);
    const auto reply = client.receive();
    ASSERT_TRUE(reply);
    EXPECT_TRUE(reply->is_binary);
    EXPECT_TRUE(reply->bytes == large);
    client.send("two");
    client.send("three");
    EXPECT_EQ(client.receive()->bytes, "a b: two");
    EXPECT_EQ(client.receive()->bytes, "a b: three");
}

TEST(Sockets, SayWhatWasWrongAndGoOn) {
    const Served served;
    WebSocketClient client(served.port);
    ASSERT_TRUE(client.open(target_of_echo));
    EXPECT_EQ(client.reply_to("fault"), "fault=50+%25+of+a+%26+b%3A+say+something+else");
    EXPECT_EQ(client.reply_to("one"), "a b: one");
    WebSocketClient nameless(served.port);
    ASSERT_TRUE(nameless.open("/echo"));
    for (int time = 0; time < 2; ++time)
        EXPECT_EQ(parse_fields(nameless.reply_to("one")).at("fault"), "name is missing; add name=...");
}

TEST(Sockets, CloseAfterAFailureAndTheServerGoesOn) {
    const Served served;
    WebSocketClient client(served.port);
    ASSERT_TRUE(client.open(target_of_echo));
    client.send("break");
    EXPECT_FALSE(client.receive());
    EXPECT_EQ(client.close_code, websocket::close_code::internal_error);
    WebSocketClient next(served.port);
    ASSERT_TRUE(next.open(target_of_echo));
    EXPECT_EQ(next.reply_to("one"), "a b: one");
}

TEST(Sockets, AreForTheServersOwnPagesOnly) {
    const Served served;
    const auto own = own_origin(served.port);
    for (const auto &origin : {own + "1", own + ".evil", own + "/", std::string("null"), std::string("http://evil"),
                               std::string(), "https" + own.substr(4)}) {
        auto request = upgrade(served.port, target_of_echo);
        request.set(http::field::origin, origin);
        EXPECT_EQ(status_of(request, served.port), 403) << origin;
    }
    auto twice = upgrade(served.port, target_of_echo);
    twice.insert(http::field::origin, own);
    EXPECT_EQ(status_of(twice, served.port), 403);
    auto without = upgrade(served.port, target_of_echo);
    without.erase(http::field::origin);
    EXPECT_EQ(status_of(without, served.port), 403);
    auto elsewhere = upgrade(served.port, target_of_echo);
    elsewhere.set(http::field::host, fmt::format("evil.example:{}", served.port));
    EXPECT_EQ(status_of(elsewhere, served.port), 403);
    auto by_name = upgrade(served.port, target_of_echo);
    by_name.set(http::field::host, fmt::format("localhost:{}", served.port));
    by_name.set(http::field::origin, fmt::format("http://localhost:{}", served.port));
    EXPECT_EQ(status_of(by_name, served.port), 101);
}

TEST(Sockets, AreOpenedAtTheirPathsOnly) {
    const Served served;
    for (const auto &[target, status] : {std::pair{"/", 404},
                                         {"/files.json", 404},
                                         {"/Echo", 404},
                                         {"/echo/?name=a", 404},
                                         {"/echo%3Fname=a", 404},
                                         {"/echo%", 400},
                                         {"/echo?name=%", 400},
                                         {"/echo?name=a&name=b", 400},
                                         {"/%65cho?name=a", 101}})
        EXPECT_EQ(status_of_upgrade(served.port, target), status) << target;
    auto plain = upgrade(served.port, target_of_echo);
    plain.erase(http::field::upgrade);
    EXPECT_EQ(status_of(plain, served.port), 404);
    auto old = upgrade(served.port, target_of_echo);
    old.set(http::field::sec_websocket_version, "8");
    EXPECT_GE(status_of(old, served.port), 400);
}

TEST(Sockets, AreAtMostEightAtATime) {
    const Served served;
    std::list<WebSocketClient> clients;
    for (int i = 0; i < 8; ++i)
        ASSERT_TRUE(clients.emplace_back(served.port).open(target_of_echo));
    EXPECT_EQ(status_of_upgrade(served.port), 503);
    for (auto &client : clients)
        EXPECT_EQ(client.reply_to("one"), "a b: one");
    clients.front().close();
    clients.back().vanish();
    clients.pop_back();
    // The two threads notice in their own time.
    int num_open = 0;
    std::list<WebSocketClient> others;
    for (int attempt = 0; attempt < 1000 && num_open < 2; ++attempt, std::this_thread::sleep_for(10ms))
        num_open += others.emplace_back(served.port).open(target_of_echo) ? 1 : 0;
    EXPECT_EQ(num_open, 2);
    EXPECT_EQ(status_of_upgrade(served.port), 503);
}

TEST(Sockets, DoNotWaitForEachOtherOrPagesForThem) {
    Served served;
    WebSocketClient slow(served.port);
    ASSERT_TRUE(slow.open(target_of_echo));
    slow.send("wait");
    served.echo.is_waiting.wait();
    WebSocketClient quick(served.port);
    ASSERT_TRUE(quick.open(target_of_echo));
    EXPECT_EQ(quick.reply_to("one"), "a b: one");
    EXPECT_EQ(status_of_upgrade(served.port, "/"), 404);
    EXPECT_EQ(quick.reply_to("go on"), "a b: go on");
    EXPECT_EQ(slow.receive()->bytes, "a b: wait");
}

TEST(Sockets, CloseWhenAMessageIsTooLarge) {
    const Served served;
    WebSocketClient client(served.port);
    ASSERT_TRUE(client.open(target_of_echo));
    const std::string largest(16 << 20, 'x');
    client.send(largest, true);
    EXPECT_EQ(client.receive()->bytes.size(), largest.size());
    client.send(largest + "x", true);
    EXPECT_FALSE(client.receive());
    EXPECT_EQ(client.close_code, websocket::close_code::too_big);
}

TEST(Sockets, OutliveClientsThatVanish) {
    const Served served;
    for (const auto *last_words : {"", "one", "wait"}) {
        WebSocketClient client(served.port);
        ASSERT_TRUE(client.open(target_of_echo));
        client.send(last_words);
        client.vanish();
    }
    WebSocketClient half(served.port);
    half.vanish();
    WebSocketClient client(served.port);
    ASSERT_TRUE(client.open(target_of_echo));
    EXPECT_EQ(client.reply_to("go on"), "a b: go on");
}

TEST(Sockets, EndWithTheServer) {
    Served served;
    WebSocketClient idle(served.port);
    ASSERT_TRUE(idle.open(target_of_echo));
    WebSocketClient talking(served.port);
    ASSERT_TRUE(talking.open(target_of_echo));
    EXPECT_EQ(talking.reply_to("one"), "a b: one");
    served.stop();
    EXPECT_FALSE(idle.receive());
    EXPECT_FALSE(talking.receive());
}

/// What goes on in the child process of the test below.
[[noreturn]] void stop_while_a_reply_is_worked_out() {
    Served served;
    WebSocketClient client(served.port);
    if (!client.open(target_of_echo))
        std::exit(2);
    client.send("wait");
    served.echo.is_waiting.wait();
    served.stop();
    std::exit(3); // the program should have ended before
}

TEST(SocketsDeathTest, EndTheProgramWithStatusZeroWhileAReplyIsWorkedOut) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    EXPECT_EXIT(stop_while_a_reply_is_worked_out(), testing::ExitedWithCode(0), "");
}

} // namespace
} // namespace livermark::server
