#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
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

/// Reason of the close frame where another session has taken the place of one.
inline constexpr auto replaced =
    "Another page took the place of this one, which had been silent; open the file again to go on.";

/// Sentence on a session that did not begin. It goes to the page as `fault=<sentence>` and as the reason of the close
/// frame.
inline constexpr auto no_room = "Eight sessions are open already; close a page that has one, and try again.";

/// Time that a WebSocket may take to open, or to close.
inline constexpr std::chrono::seconds longest_handshake{5};

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

} // namespace livermark::server
