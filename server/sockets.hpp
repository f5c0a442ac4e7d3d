#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>
#include <thread>

#include "server/conversation.hpp"

/// Internal to server/: no other header includes Boost.
namespace livermark::server {

/// The first part of a request, without what may follow it.
using RequestHead = boost::beast::http::request<boost::beast::http::empty_body>;

/// The WebSockets that are open. Each has a thread of its own that reads, replies and writes, one after the other: a
/// reply may take a second, and nothing else may wait for it. Its functions are for one thread.
class Sockets {
  public:
    static constexpr std::size_t largest_number = 8;
    static constexpr std::size_t largest_message = 16 << 20; ///< [byte]; a longer one closes its socket with code 1009

    Sockets() = default;
    Sockets(const Sockets &) = delete;
    Sockets &operator=(const Sockets &) = delete;
    ~Sockets(); ///< closes all, and waits as long as it takes

    bool has_room() const;

    /// Accepts a WebSocket in a thread of its own; the connection is closed where the machine has none left.
    /// @param socket  outlived by its io_context
    /// @param head    the request to upgrade, which has been found good
    void open(boost::asio::ip::tcp::socket socket, RequestHead head, BeginConversation begin, Fields query);

    /// Closes all.
    /// @return whether all threads came to their end in time; they do not while they work a reply out
    bool close(std::chrono::milliseconds patience);

  private:
    struct Line {
        int handle = -1; ///< a second descriptor of its socket, which is good until the thread has ended
        bool has_ended = false;
        std::jthread thread{};
    };

    void hang_up();

    mutable std::mutex mutex_; ///< of all below
    std::condition_variable one_has_ended_;
    std::list<Line> lines_; ///< destroyed before the mutex that their threads take
};

} // namespace livermark::server
