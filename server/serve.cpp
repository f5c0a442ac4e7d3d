#include "server/serve.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "core/input_error.hpp"
#include "server/sockets.hpp"

namespace livermark::server {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using tcp = asio::ip::tcp;

constexpr std::chrono::seconds longest_silence{60};
constexpr std::chrono::minutes longest_transfer{10};
constexpr std::chrono::seconds longest_farewell{1};

/// A header that stands there twice is neither of the two.
std::optional<std::string> header(const RequestHead &head, http::field name) {
    const auto [first, last] = head.equal_range(name);
    if (first == last)
        return std::nullopt;
    std::string value;
    for (auto line = first; line != last; ++line)
        value.append(line == first ? "" : ", ").append(line->value().data(), line->value().size());
    return value;
}

Request request_of(const RequestHead &head) {
    return {.method = std::string(head.method_string()),
            .target = std::string(head.target()),
            .host = header(head, http::field::host).value_or(""),
            .origin = header(head, http::field::origin)};
}

template <class Body> http::response<Body> response_to(const RequestHead &head, const Answer &answer) {
    http::response<Body> response(static_cast<http::status>(answer.status), head.version());
    response.set(http::field::content_type, answer.content_type);
    response.set(http::field::cache_control, "no-store"); // a run may write its files again at any time
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.set("Content-Security-Policy", "frame-ancestors 'none'");
    if (answer.status == 405)
        response.set(http::field::allow, "GET, HEAD");
    response.keep_alive(head.keep_alive());
    return response;
}

Answer fault(int status, const std::string &sentence) {
    return {.status = status, .content_type = "text/plain; charset=utf-8", .text = sentence + "\n", .file = {}};
}

/// Answers the requests of one connection, one after the other. It lives as long as something is under way; when the
/// browser goes away, or sends what is no request, nothing is.
class Connection : public std::enable_shared_from_this<Connection> {
  public:
    Connection(tcp::socket socket, const Site &site, Sockets &sockets)
        : stream_(std::move(socket)), site_(site), sockets_(sockets) {}

    void read() {
        head_ = {};
        stream_.expires_after(longest_silence);
        http::async_read(stream_, buffer_, head_, [self = shared_from_this()](beast::error_code error, std::size_t) {
            if (!error)
                self->reply();
        });
    }

  private:
    void reply() {
        if (beast::websocket::is_upgrade(head_))
            return upgrade();
        try {
            reply(answer(request_of(head_), site_));
        } catch (const core::InputError &error) {
            reply(fault(500, error.what())); // the folder went away
        }
    }

    void upgrade() {
        auto decision = opening(request_of(head_), site_);
        if (const auto *refusal = std::get_if<Answer>(&decision))
            return reply(*refusal);
        if (!sockets_.has_room())
            return reply(fault(503, "Too many pages are in conversation already; close one of them."));
        auto &[begin, query] = std::get<Opening>(decision);
        sockets_.open(stream_.release_socket(), std::move(head_), std::move(begin), std::move(query));
    }

    void reply(const Answer &answer) {
        if (answer.file.empty()) {
            auto response = response_to<http::string_body>(head_, answer);
            response.body() = answer.text;
            return write(std::move(response));
        }
        auto response = response_to<http::file_body>(head_, answer);
        beast::error_code error;
        response.body().open(answer.file.c_str(), beast::file_mode::scan, error);
        if (error)
            return reply(fault(404, "The file cannot be read."));
        write(std::move(response));
    }

    template <class Body> void write(http::response<Body> response) {
        // The serializer points at the response, and both have to stay where they are until all is sent.
        struct Sent {
            explicit Sent(http::response<Body> whole) : response(std::move(whole)) {}
            http::response<Body> response;
            http::response_serializer<Body> serializer{response};
        };
        response.prepare_payload();
        auto sent = std::make_shared<Sent>(std::move(response));
        auto then = [self = shared_from_this(), sent](beast::error_code error, std::size_t) {
            if (!error && self->head_.keep_alive())
                self->read();
        };
        stream_.expires_after(longest_transfer);
        if (head_.method() == http::verb::head)
            http::async_write_header(stream_, sent->serializer, std::move(then));
        else
            http::async_write(stream_, sent->serializer, std::move(then));
    }

    beast::tcp_stream stream_;
    beast::flat_buffer buffer_;
    RequestHead head_;
    const Site &site_;
    Sockets &sockets_;
};

void accept_connections(tcp::acceptor &acceptor, const Site &site, Sockets &sockets) {
    acceptor.async_accept([&](beast::error_code error, tcp::socket socket) {
        if (!error)
            std::make_shared<Connection>(std::move(socket), site, sockets)->read();
        accept_connections(acceptor, site, sockets);
    });
}

tcp::acceptor listener(asio::io_context &context, std::uint16_t port) {
    try {
        return {context, {asio::ip::address_v4::loopback(), port}};
    } catch (const boost::system::system_error &error) {
        throw core::InputError(fmt::format("port {}: cannot be used ({}); choose another with --port, or 0 for any",
                                           port, error.code().message()));
    }
}

} // namespace

void serve(Site site, const std::function<void(std::uint16_t port)> &is_ready) {
    asio::io_context context(1);
    auto acceptor = listener(context, site.port);
    site.port = acceptor.local_endpoint().port();
    asio::signal_set signals(context, SIGINT, SIGTERM);
    signals.async_wait([&](beast::error_code, int) { context.stop(); });
    Sockets sockets;
    accept_connections(acceptor, site, sockets);
    is_ready(site.port);
    context.run();
    if (!sockets.close(longest_farewell)) {
        std::fflush(nullptr);
        std::_Exit(EXIT_SUCCESS);
    }
}

} // namespace livermark::server
