#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "app/server/session.hpp"
#include "app/server/site.hpp"

/// Internal to server/: no other header includes Boost.
namespace livermark::server {

/// The first part of a request, without what may follow it.
using RequestHead = boost::beast::http::request<boost::beast::http::empty_body>;

/// Why a session ended that another one has replaced, as the reason of the close frame.
inline constexpr auto replaced =
    "Another page took the place of this one, which had been silent; open the file again to go on.";

/// Why a session did not begin. It goes to the page as `fault=<sentence>` and as the reason of the close frame.
inline constexpr auto no_room = "Eight sessions are open already; close a page that has one, and try again.";

class Talk;

/// The WebSockets that are open. Each has a thread of its own that reads, replies and writes, one after the other: a
/// reply may take a second, and nothing else may wait for it. Its functions are for one thread.
class Sockets {
  public:
    static constexpr std::size_t largest_number = 8;
    static constexpr std::size_t largest_message = 16 << 20; ///< [byte]; a longer one closes its socket with code 1009

    /// @param patience  with the other sides
    explicit Sockets(const Patience &patience);
    Sockets(const Sockets &) = delete;
    Sockets &operator=(const Sockets &) = delete;
    ~Sockets(); ///< closes all, and waits as long as it takes

    /// Whether one more can be opened: where there are largest_number, the one that has been silent for longest is
    /// closed for it, if that is long enough.
    bool make_room();

    /// Accepts a WebSocket in a thread of its own; the connection is closed where the machine has none left.
    /// @param socket  without an operation under way
    /// @param head    the request to upgrade, which has been found good
    void open(boost::asio::ip::tcp::socket socket, RequestHead head, BeginSession begin, Fields query);

    /// Closes all.
    /// @return whether all threads came to their end in time; they do not while they work a reply out
    bool close(std::chrono::milliseconds patience);

  private:
    using Clock = std::chrono::steady_clock;
    friend class Talk;

    struct Line {
        int handle = -1; ///< a second descriptor of its socket, which is good until the thread has ended
        bool has_ended = false;
        bool is_leaving = false;                         ///< has been told to make room
        Talk *talk = nullptr;                            ///< what can be told to end, while there is one
        std::optional<Clock::time_point> silent_since{}; ///< nothing while a reply is worked out
        std::jthread thread{};
    };

    void hang_up();
    void converse(Line &line, int handle, const RequestHead &head, const BeginSession &begin, const Fields &query);

    Patience patience_;
    mutable std::mutex mutex_; ///< of all below
    std::condition_variable one_has_ended_;
    std::list<Line> lines_; ///< destroyed before the mutex that their threads take
};

/// Internal to server/.

/// Time that a WebSocket may take to open, or to close.
inline constexpr std::chrono::seconds longest_handshake{5};

/// One WebSocket in its thread: each function waits until it is done.
///
/// Where the other side is silent it is asked for a sign of life with a ping, which a browser answers by itself. (The
/// timeouts of Beast would take the time in which a reply is worked out, and nothing is read, for silence.)
class Talk {
  public:
    /// @param handle   of a connection over TCP, which is the talk's from now on
    /// @param silence  after which the other side is asked whether it is there, and, without a sign, given up; and how
    ///   long it may take a write
    Talk(int handle, std::chrono::milliseconds silence);

    /// @return whether it was accepted
    bool accept(const RequestHead &head);
    /// @return nothing when the other side closes, goes away, is silent for too long or breaks the protocol; Beast then
    ///   sends the close code that fits
    std::optional<Message> read();
    /// @return whether it was written
    bool write(const Message &message);
    void close(boost::beast::websocket::close_code code, const std::string &reason);

    /// Ends a read() that is under way or comes next. The one function for other threads.
    void end(const std::string &reason);

  private:
    template <class Start> boost::beast::error_code until_done(const Start &start);
    void watch(bool may_ask);

    std::chrono::milliseconds silence_;
    boost::asio::io_context context_{1};
    boost::asio::steady_timer clock_;
    boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
};

} // namespace livermark::server
