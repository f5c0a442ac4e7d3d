#include "app/server/site.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/core/error.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <fmt/format.h>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <unistd.h>
#include <utility>
#include <variant>

#include "app/server/sockets.hpp"
#include "core/support/input_error.hpp"

/// Internal to server/.
namespace livermark::server {

class Connection;

/// The connections over which pages and files are asked for, as many as there may be at a time. Its functions are for
/// one thread.
class Connections {
  public:
    /// A browser opens six.
    static constexpr std::size_t largest_number = 64;

    /// @param site, sockets  kept alive by the caller
    Connections(const Site &site, Sockets &sockets) : site_(site), sockets_(sockets) {}

    /// Answers the requests of one connection, one after the other. Where there are as many as may be, the one that has
    /// been silent for longest is closed for it; if none is silent, the new one is.
    void add(boost::asio::ip::tcp::socket socket);

    /// Closes the connection whose other side has been silent for longest: it sends no request, or takes no reply.
    /// @return whether there was one
    bool close_most_silent();

  private:
    const Site &site_;
    Sockets &sockets_;
    std::list<std::weak_ptr<Connection>> all_;
    boost::asio::thread_pool readers_{2}; ///< look into files, while requests come in
};

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;
using tcp = asio::ip::tcp;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds longest_silence{60}; // of a side that sends nothing, or takes nothing of what is sent

/// A header that stands there twice is neither of the two.
template <class Name> std::optional<std::string> header(const RequestHead &head, Name name) {
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
            .origin = header(head, http::field::origin),
            .fetch_site = header(head, "Sec-Fetch-Site"),
            .cookies = header(head, http::field::cookie).value_or("")};
}

/// The page is one file with its scripts, styles, workers and WebAssembly in it: it needs nothing from elsewhere, and
/// speaks to this server only.
std::string content_policy(std::uint16_t port) {
    return fmt::format("default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'unsafe-inline'; "
                       "worker-src blob: data:; img-src data: blob:; connect-src 'self' ws://127.0.0.1:{0} "
                       "ws://localhost:{0}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
                       port);
}

template <class Body>
http::response<Body> response_to(const RequestHead &head, const Response &answer, std::uint16_t port) {
    http::response<Body> response(static_cast<http::status>(answer.status), head.version());
    response.set(http::field::content_type, answer.content_type);
    response.set(http::field::cache_control, "no-store"); // a run may write its files again at any time
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.set("Content-Security-Policy", content_policy(port));
    response.set("Cross-Origin-Opener-Policy", "same-origin");
    response.set("Referrer-Policy", "no-referrer"); // the address may have the token
    if (!answer.set_cookie.empty())
        response.set(http::field::set_cookie, answer.set_cookie);
    if (answer.status == 405)
        response.set(http::field::allow, "GET, HEAD");
    response.keep_alive(head.keep_alive());
    return response;
}

Response fault(int status, const std::string &sentence) {
    return {.status = status, .content_type = "text/plain; charset=utf-8", .text = sentence + "\n", .file = {}};
}

using boost::beast::error_code;

constexpr std::chrono::seconds longest_farewell{1};
constexpr std::chrono::milliseconds pause_without_descriptors{100};

/// Programs that this one starts have no business with its sockets.
void keep_from_children(int handle) {
    ::fcntl(handle, F_SETFD, FD_CLOEXEC);
}

/// A descriptor that is there to be given up.
class Reserve {
  public:
    Reserve() { take(); }
    ~Reserve() { give_up(); }
    Reserve(const Reserve &) = delete;
    Reserve &operator=(const Reserve &) = delete;
    void take() {
        if (handle_ < 0)
            handle_ = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    }
    void give_up() {
        if (handle_ >= 0)
            ::close(handle_);
        handle_ = -1;
    }

  private:
    int handle_ = -1;
};

tcp::acceptor listener(asio::io_context &context, std::uint16_t port) {
    try {
        tcp::acceptor acceptor(context, {asio::ip::address_v4::loopback(), port});
        keep_from_children(acceptor.native_handle());
        return acceptor;
    } catch (const boost::system::system_error &error) {
        throw support::InputError(fmt::format("port {}: cannot be used ({}); choose another with --port, or 0 for any",
                                              port, error.code().message()));
    }
}

/// Lets connections in.
class Door {
  public:
    Door(asio::io_context &context, tcp::acceptor &acceptor, Connections &connections)
        : acceptor_(acceptor), connections_(connections), pause_(context) {}

    void open() {
        acceptor_.async_accept([this](error_code error, tcp::socket socket) {
            if (error == asio::error::operation_aborted)
                return;
            if (error)
                return turn_away();
            keep_from_children(socket.native_handle());
            connections_.add(std::move(socket));
            open();
        });
    }

  private:
    /// There is no descriptor for whoever is first in the queue. A connection that is silent makes place for it; if
    /// none is, it is closed rather than left to wait. Either way others get a while to end what they are at: the
    /// queue would be tried again at once, for as long as there is nothing to be had.
    void turn_away() {
        if (!connections_.close_most_silent()) {
            reserve_.give_up();
            tcp::socket refused(acceptor_.get_executor());
            error_code error;
            acceptor_.non_blocking(true, error);
            acceptor_.accept(refused, error);
        }
        reserve_.take();
        pause_.expires_after(pause_without_descriptors);
        pause_.async_wait([this](error_code error) {
            if (!error)
                open();
        });
    }

    tcp::acceptor &acceptor_;
    Connections &connections_;
    asio::steady_timer pause_;
    Reserve reserve_;
};

} // namespace

/// Answers the requests of one connection, one after the other. It lives as long as something is under way; when the
/// browser goes away, or sends what is no request, nothing is.
class Connection : public std::enable_shared_from_this<Connection> {
  public:
    /// @param readers  decide on requests, which may take them a while
    Connection(tcp::socket socket, const Site &site, Sockets &sockets, asio::thread_pool &readers)
        : stream_(std::move(socket)), site_(site), sockets_(sockets), readers_(readers) {}

    void read() {
        head_ = {};
        silent_since_ = Clock::now();
        stream_.expires_after(longest_silence);
        http::async_read(stream_, buffer_, head_, [self = shared_from_this()](beast::error_code error, std::size_t) {
            self->silent_since_.reset();
            if (!error)
                self->reply();
        });
    }

    /// Nothing while a reply is worked out.
    std::optional<Clock::time_point> silent_since() const { return silent_since_; }

    void close() {
        silent_since_.reset();
        stream_.close();
    }

  private:
    void reply() {
        if (websocket::is_upgrade(head_))
            return upgrade();
        asio::post(readers_, [self = shared_from_this(), request = request_of(head_)] {
            auto answer = self->answer_to(request);
            asio::post(self->stream_.get_executor(), [self, answer = std::move(answer)] { self->reply(answer); });
        });
    }

    /// In a thread of its own.
    Response answer_to(const Request &request) const {
        try {
            return respond(request, site_);
        } catch (const support::InputError &error) {
            return fault(500, error.what()); // the folder went away
        } catch (const std::exception &error) {
            return fault(500, error.what()); // no memory or descriptors
        }
    }

    void upgrade() {
        auto decision = opening(request_of(head_), site_);
        if (const auto *refusal = std::get_if<Response>(&decision))
            return reply(*refusal);
        if (!sockets_.make_room())
            return refuse_upgrade();
        auto &[begin, query] = std::get<Opening>(decision);
        sockets_.open(stream_.release_socket(), std::move(head_), std::move(begin), std::move(query));
    }

    /// A browser does not show its page why a WebSocket was refused: it is opened to say so.
    void refuse_upgrade() {
        stream_.expires_never(); // the WebSocket has a clock of its own
        refusal_.emplace(std::move(stream_));
        refusal_->set_option(websocket::stream_base::timeout{
            .handshake_timeout = longest_handshake, .idle_timeout = longest_handshake, .keep_alive_pings = false});
        refusal_->async_accept(head_, [self = shared_from_this()](beast::error_code error) {
            if (error)
                return;
            self->refusal_->text(true);
            self->refusal_->async_write(
                asio::buffer(self->refusal_text_), [self](beast::error_code failure, std::size_t) {
                    if (!failure)
                        self->refusal_->async_close({websocket::close_code::try_again_later, no_room},
                                                    [self](beast::error_code) {});
                });
        });
    }

    void reply(const Response &answer) {
        if (answer.file.empty()) {
            auto response = response_to<http::string_body>(head_, answer, site_.port);
            response.body() = answer.text;
            return write(std::move(response));
        }
        auto response = response_to<http::file_body>(head_, answer, site_.port);
        beast::error_code error;
        response.body().open(answer.file.c_str(), beast::file_mode::scan, error);
        if (error)
            return reply(fault(404, "The file cannot be read."));
        write(std::move(response));
    }

    /// The serializer points at the response, and both have to stay where they are until all is sent.
    template <class Body> struct Sent {
        explicit Sent(http::response<Body> whole) : response(std::move(whole)) { response.prepare_payload(); }
        http::response<Body> response;
        http::response_serializer<Body> serializer{response};
    };

    template <class Body> void write(http::response<Body> response) {
        const auto sent = std::make_shared<Sent<Body>>(std::move(response));
        sent->serializer.split(head_.method() == http::verb::head);
        write_on(sent);
    }

    /// Piece by piece: whoever asks and does not take the reply is as silent as one who does not ask.
    template <class Body> void write_on(const std::shared_ptr<Sent<Body>> &sent) {
        silent_since_ = Clock::now();
        stream_.expires_after(longest_silence);
        http::async_write_some(stream_, sent->serializer,
                               [self = shared_from_this(), sent](beast::error_code error, std::size_t) {
                                   self->silent_since_.reset();
                                   if (error)
                                       return;
                                   const bool is_head = self->head_.method() == http::verb::head;
                                   if (is_head ? !sent->serializer.is_header_done() : !sent->serializer.is_done())
                                       self->write_on(sent);
                                   else if (self->head_.keep_alive())
                                       self->read();
                               });
    }

    beast::tcp_stream stream_;
    std::optional<websocket::stream<beast::tcp_stream>> refusal_; ///< has taken the stream
    const std::string refusal_text_ = fields_text({{"fault", no_room}});
    beast::flat_buffer buffer_;
    RequestHead head_;
    std::optional<Clock::time_point> silent_since_;
    const Site &site_;
    Sockets &sockets_;
    asio::thread_pool &readers_;
};

void Connections::add(tcp::socket socket) {
    std::erase_if(all_, [](const auto &connection) { return connection.expired(); });
    if (all_.size() >= largest_number && !close_most_silent())
        return; // the socket is closed
    const auto connection = std::make_shared<Connection>(std::move(socket), site_, sockets_, readers_);
    all_.push_back(connection);
    connection->read();
}

bool Connections::close_most_silent() {
    std::shared_ptr<Connection> most_silent;
    for (const auto &known : all_)
        if (const auto connection = known.lock(); connection && connection->silent_since())
            if (!most_silent || *connection->silent_since() < *most_silent->silent_since())
                most_silent = connection;
    if (most_silent)
        most_silent->close();
    return most_silent != nullptr;
}

void serve(Site site, const std::function<void(std::uint16_t port)> &is_ready, const Patience &patience) {
    asio::io_context context(1);
    auto acceptor = listener(context, site.port);
    site.port = acceptor.local_endpoint().port();
    asio::signal_set signals(context, SIGINT, SIGTERM);
    signals.async_wait([&](error_code, int) { context.stop(); });
    Sockets sockets(patience);
    Connections connections(site, sockets);
    Door door(context, acceptor, connections);
    door.open();
    is_ready(site.port);
    context.run();
    if (!sockets.close(longest_farewell)) {
        std::fflush(nullptr);
        std::_Exit(EXIT_SUCCESS);
    }
}

} // namespace livermark::server
