#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstddef>
#include <list>
#include <memory>

#include "server/site.hpp"
#include "server/sockets.hpp"

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

} // namespace livermark::server
