#include "server/serve.hpp"

#include <utility> // Boost 1.74 uses it without including it

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <csignal>
#include <exception>
#include <fmt/format.h>
#include <optional>
#include <string>

#include "core/input_error.hpp"

namespace livermark::server {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using tcp = asio::ip::tcp;

constexpr std::chrono::seconds longest_silence{60};
constexpr std::chrono::minutes longest_transfer{10};

using RequestHead = http::request<http::empty_body>;

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

template <class Body>
asio::awaitable<void> send(beast::tcp_stream &stream, const RequestHead &head, http::response<Body> response) {
    response.prepare_payload();
    http::response_serializer<Body> serializer(response);
    stream.expires_after(longest_transfer);
    if (head.method() == http::verb::head)
        co_await http::async_write_header(stream, serializer, asio::use_awaitable);
    else
        co_await http::async_write(stream, serializer, asio::use_awaitable);
}

asio::awaitable<void> send_answer(beast::tcp_stream &stream, const RequestHead &head, Answer answer) {
    if (!answer.file.empty()) {
        auto response = response_to<http::file_body>(head, answer);
        beast::error_code error;
        response.body().open(answer.file.c_str(), beast::file_mode::scan, error);
        if (!error) {
            co_await send(stream, head, std::move(response));
            co_return;
        }
        answer = {.status = 404, .content_type = "text/plain", .text = "The file cannot be read.\n", .file = {}};
    }
    auto response = response_to<http::string_body>(head, answer);
    response.body() = std::move(answer.text);
    co_await send(stream, head, std::move(response));
}

asio::awaitable<void> serve_connection(tcp::socket socket, const Site &site) {
    beast::tcp_stream stream(std::move(socket));
    beast::flat_buffer buffer;
    try {
        for (bool goes_on = true; goes_on;) {
            RequestHead head;
            stream.expires_after(longest_silence);
            co_await http::async_read(stream, buffer, head, asio::use_awaitable);
            goes_on = head.keep_alive();
            co_await send_answer(stream, head, answer(request_of(head), site));
        }
    } catch (const std::exception &error) {
        // The browser went away, or sent what is no request: an end to this connection and to nothing else.
    }
}

asio::awaitable<void> accept_connections(tcp::acceptor &acceptor, const Site &site) {
    for (;;) {
        auto socket = co_await acceptor.async_accept(asio::use_awaitable);
        asio::co_spawn(acceptor.get_executor(), serve_connection(std::move(socket), site), asio::detached);
    }
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
    std::exception_ptr fault;
    asio::co_spawn(context, accept_connections(acceptor, site), [&](std::exception_ptr end) {
        fault = std::move(end);
        context.stop();
    });
    is_ready(site.port);
    context.run();
    if (fault)
        std::rethrow_exception(fault);
}

} // namespace livermark::server
