#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <optional>
#include <string>

#include "server/session.hpp"
#include "server/sockets.hpp"

/// Internal to server/.
namespace livermark::server {

/// How long a WebSocket may take to open, or to close.
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
