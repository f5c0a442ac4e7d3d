#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <fmt/format.h>
#include <future>
#include <gtest/gtest.h>
#include <iterator>
#include <latch>
#include <list>
#include <stdexcept>
#include <string>
#include <thread>

#include "app/server/site.hpp"
#include "core/support/input_error.hpp"
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
    Session begin(const Fields &query, const ReportProgress &report);
};

Session Echo::begin(const Fields &query, const ReportProgress &report) {
    const auto name = required_text(query, "name");
    return [this, name, report](const Message &message) -> Message {
        if (message.bytes == "tell") {
            report("1 & 2");
            report("2");
        }
        if (message.bytes == "work")
            while (report("at work"))
                std::this_thread::sleep_for(5ms);
        if (message.bytes == "fault")
            throw support::InputError("50 % of a & b: say something else");
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

struct Served {
    explicit Served(const Patience &patience = {}) : patience(patience) {}
    void stop() { in_thread.stop(); }

    Echo echo;
    Patience patience;
    tests::ServedInThread in_thread{
        tests::empty_site({{"/echo", [this](const Fields &query,
                                            const ReportProgress &report) { return echo.begin(query, report); }}}),
        patience};
    std::uint16_t port = in_thread.port;
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

TEST(Sockets, TellASessionThatItsReplyIsNotWaitedForAnyLonger) {
    const Served served;
    WebSocketClient client(served.port);
    ASSERT_TRUE(client.open(target_of_echo));
    client.send("work");
    const std::string progress = "progress=at+work";
    EXPECT_EQ(client.receive()->bytes, progress);
    client.send("next");
    auto reply = client.receive();
    while (reply && reply->bytes == progress)
        reply = client.receive();
    EXPECT_EQ(reply->bytes, "a b: work");
    EXPECT_EQ(client.receive()->bytes, "a b: next");
    client.send("work");
    EXPECT_EQ(client.receive()->bytes, progress);
    // Destroyed, it is gone: the server stops all the same.
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
    for (const auto *cookie : {"", "livermark_1=0123456789abcdef", "0123456789abcdef", "livermark_=0123456789abcdef"}) {
        auto stranger = upgrade(served.port, target_of_echo);
        stranger.set(http::field::cookie, cookie);
        EXPECT_EQ(status_of(stranger, served.port), 403) << cookie;
    }
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

TEST(Sockets, TellWhatAReplyWaitsForBeforeIt) {
    const Served served;
    WebSocketClient client(served.port);
    ASSERT_TRUE(client.open(target_of_echo));
    EXPECT_EQ(client.reply_to("tell"), "progress=1+%26+2");
    EXPECT_EQ(client.receive()->bytes, "progress=2");
    EXPECT_EQ(client.receive()->bytes, "a b: tell");
}

/// Opens one more, which must not find room.
void expect_no_room(std::uint16_t port) {
    WebSocketClient client(port);
    ASSERT_TRUE(client.open(target_of_echo));
    const auto fault = client.receive();
    ASSERT_TRUE(fault);
    EXPECT_NE(parse_fields(fault->bytes).at("fault").find("Eight sessions are open"), std::string::npos);
    EXPECT_FALSE(client.receive());
    EXPECT_EQ(client.close_code, websocket::close_code::try_again_later);
    EXPECT_EQ(client.close_reason, parse_fields(fault->bytes).at("fault"));
}

TEST(Sockets, AreAtMostEightAtATimeAndSayWhyThereAreNoMore) {
    const Served served(Patience{.until_replaced = 1h});
    std::list<WebSocketClient> clients;
    for (int i = 0; i < 8; ++i)
        ASSERT_TRUE(clients.emplace_back(served.port).open(target_of_echo));
    for (auto &client : clients)
        EXPECT_EQ(client.reply_to("one"), "a b: one");
    expect_no_room(served.port);
    for (auto &client : clients)
        EXPECT_EQ(client.reply_to("two"), "a b: two");
    clients.front().close();
    clients.back().vanish();
    clients.pop_back();
    clients.pop_front();
    // The two threads notice in their own time.
    for (int attempt = 0; attempt < 1000 && clients.size() < 8; ++attempt, std::this_thread::sleep_for(10ms))
        if (auto &other = clients.emplace_back(served.port);
            !other.open(target_of_echo) || other.reply_to("one") != "a b: one")
            clients.pop_back();
    EXPECT_EQ(clients.size(), 8U);
    expect_no_room(served.port);
}

TEST(Sockets, YieldToANewOneWhenTheyAreSilent) {
    const Served served(Patience{.until_replaced = 50ms});
    std::list<WebSocketClient> clients;
    for (int i = 0; i < 8; ++i) {
        ASSERT_TRUE(clients.emplace_back(served.port).open(target_of_echo));
        EXPECT_EQ(clients.back().reply_to("one"), "a b: one");
    }
    EXPECT_EQ(clients.front().reply_to("two"), "a b: two"); // so that the second has been silent for longest
    std::this_thread::sleep_for(100ms);
    WebSocketClient ninth(served.port);
    ASSERT_TRUE(ninth.open(target_of_echo));
    EXPECT_EQ(ninth.reply_to("one"), "a b: one");
    auto &second = *std::next(clients.begin());
    EXPECT_FALSE(second.receive());
    EXPECT_EQ(second.close_code, websocket::close_code::try_again_later);
    EXPECT_NE(second.close_reason.find("took the place of this one"), std::string::npos);
    EXPECT_EQ(clients.front().reply_to("three"), "a b: three");
}

TEST(Sockets, ThatGiveNoSignOfLifeAreClosed) {
    const Served served(Patience{.silence = 100ms});
    WebSocketClient silent(served.port);
    ASSERT_TRUE(silent.open(target_of_echo));
    EXPECT_EQ(silent.reply_to("one"), "a b: one");
    // A client that does not read answers no ping. What comes to its connection is the ping, and then the end.
    std::string raw(1000, '\0');
    boost::system::error_code error;
    std::size_t size = 0;
    while (!error)
        size += silent.connection().read_some(boost::asio::buffer(raw.data() + size, raw.size() - size), error);
    EXPECT_EQ(error, boost::asio::error::eof);
    EXPECT_EQ(raw.substr(0, size), std::string("\x89\0", 2));
}

TEST(Sockets, ThatAnswerPingsStayThoughTheyAreSilent) {
    Served served(Patience{.silence = 500ms});
    WebSocketClient client(served.port);
    ASSERT_TRUE(client.open(target_of_echo));
    // The client waits for a message, and answers pings meanwhile.
    auto received = std::async(std::launch::async, [&] { return client.receive(); });
    EXPECT_EQ(received.wait_for(2500ms), std::future_status::timeout);
    WebSocketClient slow(served.port);
    ASSERT_TRUE(slow.open(target_of_echo));
    slow.send("wait"); // for longer than the patience, while nothing is read from this one
    served.echo.is_waiting.wait();
    std::this_thread::sleep_for(1500ms);
    WebSocketClient other(served.port);
    ASSERT_TRUE(other.open(target_of_echo));
    EXPECT_EQ(other.reply_to("go on"), "a b: go on");
    EXPECT_EQ(slow.receive()->bytes, "a b: wait");
    client.vanish();
    EXPECT_FALSE(received.get());
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

/// Work of the child process of the test below.
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
