#include "server/talk.hpp"

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/websocket.hpp>
#include <unistd.h>

namespace livermark::server {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using tcp = asio::ip::tcp;

tcp::socket taken_over(asio::io_context &context, int handle) {
    tcp::socket socket(context);
    beast::error_code error;
    socket.assign(tcp::v4(), handle, error);
    if (error)
        ::close(handle);
    return socket;
}

} // namespace

Talk::Talk(int handle, std::chrono::milliseconds silence)
    : silence_(silence), clock_(context_), stream_(taken_over(context_, handle)) {
    beast::error_code error;
    // A reply of two packets would wait for the acknowledgement of one.
    beast::get_lowest_layer(stream_).socket().set_option(tcp::no_delay(true), error);
    stream_.set_option(websocket::stream_base::timeout{.handshake_timeout = longest_handshake,
                                                       .idle_timeout = websocket::stream_base::none(),
                                                       .keep_alive_pings = false});
    stream_.read_message_max(Sockets::largest_message);
    stream_.auto_fragment(false);
}

template <class Start> beast::error_code Talk::until_done(const Start &start) {
    std::optional<beast::error_code> ending;
    start([&ending](beast::error_code error, std::size_t = 0) { ending = error; });
    context_.restart();
    while (!ending)
        context_.run_one();
    return *ending;
}

/// Until the clock is set anew.
/// @param may_ask  whether the other side is pinged before it is given up
void Talk::watch(bool may_ask) {
    clock_.expires_after(silence_);
    clock_.async_wait([this, may_ask](beast::error_code error) {
        if (error)
            return; // in time
        if (!may_ask)
            return beast::get_lowest_layer(stream_).close();
        stream_.async_ping({}, [](beast::error_code) {});
        watch(false);
    });
}

bool Talk::accept(const RequestHead &head) {
    return !until_done([&](const auto &then) { stream_.async_accept(head, then); });
}

std::optional<Message> Talk::read() {
    Message message;
    auto bytes = asio::dynamic_buffer(message.bytes);
    constexpr std::size_t at_once = 64 << 10; // each piece of a long message is a sign of life
    stream_.control_callback([this](websocket::frame_type, beast::string_view) { watch(true); }); // it is there
    beast::error_code error;
    do {
        watch(true);
        error = until_done([&](const auto &then) { stream_.async_read_some(bytes, at_once, then); });
    } while (!error && !stream_.is_message_done());
    clock_.cancel();
    if (error)
        return std::nullopt;
    message.is_binary = stream_.got_binary();
    return message;
}

bool Talk::write(const Message &message) {
    stream_.binary(message.is_binary);
    watch(false);
    const auto error = until_done([&](const auto &then) { stream_.async_write(asio::buffer(message.bytes), then); });
    clock_.cancel();
    return !error;
}

void Talk::close(websocket::close_code code, const std::string &reason) {
    until_done([&](const auto &then) { stream_.async_close({code, reason}, then); });
}

void Talk::end(const std::string &reason) {
    asio::post(context_, [this, reason] {
        stream_.async_close({websocket::close_code::try_again_later, reason}, [](beast::error_code) {});
    });
}

} // namespace livermark::server
