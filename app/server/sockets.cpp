#include "app/server/sockets.hpp"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdio>
#include <exception>
#include <fcntl.h>
#include <fmt/format.h>
#include <string>
#include <sys/socket.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/support/processes/own_process.hpp"

namespace livermark::server {

/// One WebSocket in its thread: each function waits until it is done.
///
/// A silent other side is asked for a sign of life with a ping, which a browser answers by itself. (The
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
    /// @return whether the other side has sent something that is still to be read, or has gone
    bool has_more();
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

namespace {

using tcp = boost::asio::ip::tcp;

Session begun(const BeginSession &begin, const Fields &query, const ReportProgress &report) {
    try {
        return begin(query, report);
    } catch (const support::InputError &error) {
        return [error](const Message &) -> Message { throw error; };
    }
}

Message reply_of(const Session &session, const Message &message) {
    try {
        return session(message);
    } catch (const support::InputError &error) {
        return {.is_binary = false, .bytes = fields_text({{"fault", error.what()}})};
    }
}

/// Says on standard error why it failed, and to the other side that it did.
void fail(Talk &talk, const std::string &reason) {
    fmt::print(stderr, "livermark: failed: {}\n", reason);
    talk.close(boost::beast::websocket::close_code::internal_error, "the reply failed; the terminal says why");
}

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

Sockets::Sockets(const Patience &patience) : patience_(patience) {}

Sockets::~Sockets() {
    hang_up();
}

bool Sockets::make_room() {
    const std::lock_guard lock(mutex_);
    Line *most_silent = nullptr;
    std::size_t number = 0;
    for (auto &line : lines_) {
        if (line.has_ended || line.is_leaving)
            continue;
        ++number;
        if (line.talk && line.silent_since && (!most_silent || *line.silent_since < *most_silent->silent_since))
            most_silent = &line;
    }
    if (number < largest_number)
        return true;
    if (!most_silent || Clock::now() - *most_silent->silent_since < patience_.until_replaced)
        return false;
    most_silent->talk->end(replaced);
    most_silent->is_leaving = true;
    return true;
}

void Sockets::converse(Line &line, int handle, const RequestHead &head, const BeginSession &begin,
                       const Fields &query) {
    Talk talk(handle, patience_.silence);
    if (!talk.accept(head))
        return;
    const ReportProgress report = [&talk](const std::string &sentence) {
        return talk.write({.is_binary = false, .bytes = fields_text({{"progress", sentence}})}) && !talk.has_more();
    };
    const auto wait = [&](bool is_waiting) {
        const std::lock_guard lock(mutex_);
        line.talk = &talk;
        line.silent_since = is_waiting ? std::optional(Clock::now()) : std::nullopt;
    };
    try {
        const auto session = begun(begin, query, report);
        while (true) {
            wait(true);
            const auto message = talk.read();
            wait(false);
            if (!message || !talk.write(reply_of(session, *message)))
                break;
        }
    } catch (const std::exception &fault) {
        fail(talk, support::reason_of(fault, "close other pages, or take a mesh of fewer tetrahedra"));
    } catch (...) {
        fail(talk, "a reason that has no name");
    }
    const std::lock_guard lock(mutex_);
    line.talk = nullptr;
}

void Sockets::open(tcp::socket socket, RequestHead head, BeginSession begin, Fields query) {
    const std::lock_guard lock(mutex_);
    std::erase_if(lines_, [](const Line &line) { return line.has_ended; });
    const int second_handle = ::fcntl(socket.native_handle(), F_DUPFD_CLOEXEC, 0);
    if (second_handle < 0)
        return;
    boost::system::error_code error;
    const int handle = socket.release(error); // another io_context runs it from now on
    if (error) {
        ::close(second_handle);
        return;
    }
    auto &line = lines_.emplace_back();
    line.handle = second_handle;
    try {
        line.thread = std::jthread(
            [this, &line, handle, head = std::move(head), begin = std::move(begin), query = std::move(query)] {
                try {
                    converse(line, handle, head, begin, query);
                } catch (const std::exception &fault) { // no descriptors are left
                    fmt::print(stderr, "livermark: a session failed to begin: {}\n", fault.what());
                }
                const std::lock_guard ending(mutex_);
                ::close(line.handle);
                line.has_ended = true;
                one_has_ended_.notify_all();
            });
    } catch (const std::system_error &) {
        ::close(handle);
        ::close(second_handle);
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

bool Talk::has_more() {
    beast::error_code error;
    return beast::get_lowest_layer(stream_).socket().available(error) > 0 || error;
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
