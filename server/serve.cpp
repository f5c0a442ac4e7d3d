#include "server/serve.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/error.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <utility>

#include "server/connection.hpp"
#include "server/sockets.hpp"
#include "support/input_error.hpp"

namespace livermark::server {

namespace {

namespace asio = boost::asio;
using boost::beast::error_code;
using tcp = asio::ip::tcp;

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
