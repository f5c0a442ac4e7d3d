#include "server/sockets.hpp"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <string>
#include <sys/socket.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "core/input_error.hpp"

namespace livermark::server {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = boost::beast::websocket;
using tcp = asio::ip::tcp;
using Stream = websocket::stream<tcp::socket>;

Conversation begun(const BeginConversation &begin, const Fields &query) {
    try {
        return begin(query);
    } catch (const core::InputError &error) {
        return [error](const Message &) -> Message { throw error; };
    }
}

Message reply_of(const Conversation &conversation, const Message &message) {
    try {
        return conversation(message);
    } catch (const core::InputError &error) {
        return {.is_binary = false, .bytes = fields_text({{"fault", error.what()}})};
    }
}

/// Until the other side closes, goes away or breaks the protocol; Beast then sends the close code that fits.
void exchange_messages(Stream &stream, const BeginConversation &begin, const Fields &query) {
    const auto conversation = begun(begin, query);
    beast::error_code error;
    while (true) {
        Message message;
        auto bytes = asio::dynamic_buffer(message.bytes);
        stream.read(bytes, error);
        if (error)
            return;
        message.is_binary = stream.got_binary();
        const auto reply = reply_of(conversation, message);
        stream.binary(reply.is_binary);
        stream.write(asio::buffer(reply.bytes), error);
        if (error)
            return;
    }
}

void converse(tcp::socket socket, const RequestHead &head, const BeginConversation &begin, const Fields &query) {
    beast::error_code error;
    socket.set_option(tcp::no_delay(true), error); // a reply of two packets would wait for the acknowledgement of one
    Stream stream(std::move(socket));
    stream.read_message_max(Sockets::largest_message);
    stream.auto_fragment(false);
    stream.accept(head, error);
    if (error)
        return;
    try {
        exchange_messages(stream, begin, query);
        return;
    } catch (const std::exception &fault) {
        fmt::print(stderr, "livermark: failed: {}\n", fault.what());
    } catch (...) {
        fmt::print(stderr, "livermark: failed for a reason that has no name\n");
    }
    stream.close({websocket::close_code::internal_error, "the reply failed; the terminal says why"}, error);
}

} // namespace

Sockets::~Sockets() {
    hang_up();
}

bool Sockets::has_room() const {
    const std::lock_guard lock(mutex_);
    return std::ranges::count(lines_, false, &Line::has_ended) < static_cast<std::ptrdiff_t>(largest_number);
}

void Sockets::open(tcp::socket socket, RequestHead head, BeginConversation begin, Fields query) {
    const std::lock_guard lock(mutex_);
    std::erase_if(lines_, [](const Line &line) { return line.has_ended; });
    const int handle = ::dup(socket.native_handle());
    if (handle < 0)
        return;
    auto &line = lines_.emplace_back();
    line.handle = handle;
    try {
        line.thread = std::jthread([this, &line, socket = std::move(socket), head = std::move(head),
                                    begin = std::move(begin), query = std::move(query)]() mutable {
            converse(std::move(socket), head, begin, query);
            const std::lock_guard ending(mutex_);
            ::close(line.handle);
            line.has_ended = true;
            one_has_ended_.notify_all();
        });
    } catch (const std::system_error &) {
        ::close(handle);
        lines_.pop_back();
    }
}

void Sockets::hang_up() {
    // A thread that waits for its socket is woken by the end of the connection; the socket itself stays its own.
    const std::lock_guard lock(mutex_);
    for (const auto &line : lines_)
        if (!line.has_ended)
            ::shutdown(line.handle, SHUT_RDWR);
}

bool Sockets::close(std::chrono::milliseconds patience) {
    hang_up();
    std::unique_lock lock(mutex_);
    return one_has_ended_.wait_for(lock, patience, [this] { return std::ranges::all_of(lines_, &Line::has_ended); });
}

} // namespace livermark::server
