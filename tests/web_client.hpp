#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <csignal>
#include <cstdint>
#include <fmt/format.h>
#include <future>
#include <optional>
#include <string>
#include <thread>
#include <unistd.h>
#include <utility>

#include "app/server/site.hpp"

/// Requests of a browser to a server on this machine, and what nobody else should.
namespace livermark::tests {

using UpgradeRequest = boost::beast::http::request<boost::beast::http::empty_body>;

inline std::string own_host(std::uint16_t port) {
    return fmt::format("127.0.0.1:{}", port);
}

inline std::string own_origin(std::uint16_t port) {
    return "http://" + own_host(port);
}

/// Token of the servers of the tests.
inline constexpr auto token = "0123456789abcdef";

/// Cookie that a browser sends after its first visit.
inline std::string own_cookie(std::uint16_t port) {
    return fmt::format("livermark_{}={}", port, token);
}

/// A request to upgrade as a page sends it.
inline UpgradeRequest upgrade(std::uint16_t port, const std::string &target) {
    UpgradeRequest request(boost::beast::http::verb::get, target, 11);
    request.set(boost::beast::http::field::host, own_host(port));
    request.set(boost::beast::http::field::origin, own_origin(port));
    request.set(boost::beast::http::field::cookie, own_cookie(port));
    request.set(boost::beast::http::field::connection, "Upgrade");
    request.set(boost::beast::http::field::upgrade, "websocket");
    request.set(boost::beast::http::field::sec_websocket_version, "13");
    request.set(boost::beast::http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
    return request;
}

using Response = boost::beast::http::response<boost::beast::http::string_body>;

/// Answer of HTTP.
inline Response response_to(const UpgradeRequest &request, std::uint16_t port) {
    boost::asio::io_context context;
    boost::asio::ip::tcp::socket socket(context);
    socket.connect({boost::asio::ip::address_v4::loopback(), port});
    boost::beast::http::write(socket, request);
    boost::beast::flat_buffer buffer;
    Response response;
    boost::beast::http::read(socket, buffer, response);
    return response;
}

/// Which is 101 where a WebSocket begins.
inline int status_of(const UpgradeRequest &request, std::uint16_t port) {
    return static_cast<int>(response_to(request, port).result_int());
}

/// A WebSocket of a page.
class WebSocketClient {
  public:
    explicit WebSocketClient(std::uint16_t port) : port_(port), stream_(context_) {
        boost::beast::get_lowest_layer(stream_).connect({boost::asio::ip::address_v4::loopback(), port});
    }

    bool open(const std::string &target) {
        stream_.set_option(
            boost::beast::websocket::stream_base::decorator([this](boost::beast::websocket::request_type &request) {
                request.set(boost::beast::http::field::origin, own_origin(port_));
                request.set(boost::beast::http::field::cookie, own_cookie(port_));
            }));
        boost::beast::error_code error;
        stream_.handshake(own_host(port_), target, error);
        return !error;
    }
    void send(const std::string &bytes, bool is_binary = false) {
        boost::beast::error_code error; // of a server that has closed while this was still being written
        stream_.binary(is_binary);
        stream_.write(boost::asio::buffer(bytes), error);
    }
    /// @return nothing if the socket was closed; close_code says how
    std::optional<server::Message> receive() {
        server::Message message;
        auto bytes = boost::asio::dynamic_buffer(message.bytes);
        boost::beast::error_code error;
        stream_.read(bytes, error);
        if (error) {
            close_code = stream_.reason().code;
            close_reason = stream_.reason().reason.c_str();
            return std::nullopt;
        }
        message.is_binary = stream_.got_binary();
        return message;
    }
    std::string reply_to(const std::string &text) {
        send(text);
        const auto reply = receive();
        return reply ? reply->bytes : "closed";
    }
    void vanish() { boost::beast::get_lowest_layer(stream_).close(); }
    void close() {
        boost::beast::error_code error;
        stream_.close(boost::beast::websocket::close_code::normal, error);
    }

    /// The bytes that WebSockets are made of.
    boost::asio::ip::tcp::socket &connection() { return boost::beast::get_lowest_layer(stream_); }

    int close_code = 0;
    std::string close_reason{};

  private:
    std::uint16_t port_;
    boost::asio::io_context context_;
    boost::beast::websocket::stream<boost::asio::ip::tcp::socket> stream_;
};

/// A site with no files, at a port that is free.
inline server::Site empty_site(std::map<std::string, server::BeginSession> sessions = {}) {
    return {.folder = "/nowhere",
            .page = "/nowhere/index.html",
            .port = 0,
            .token = token,
            .is_result_file = {},
            .sessions = std::move(sessions)};
}

/// serve() in a thread, until the signal that Ctrl-C sends.
class ServedInThread {
  public:
    explicit ServedInThread(server::Site site, const server::Patience &patience = {}) {
        std::promise<std::uint16_t> is_ready;
        auto port_in_future = is_ready.get_future();
        thread_ = std::thread([site = std::move(site), patience, is_ready = std::move(is_ready)]() mutable {
            server::serve(
                std::move(site), [&](std::uint16_t port) { is_ready.set_value(port); }, patience);
        });
        port = port_in_future.get();
    }
    ~ServedInThread() { stop(); }
    void stop() {
        if (!thread_.joinable())
            return;
        kill(getpid(), SIGINT);
        thread_.join();
    }

    std::uint16_t port = 0;

  private:
    std::thread thread_;
};

} // namespace livermark::tests
