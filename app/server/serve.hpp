#pragma once

#include <chrono>
#include <cstdint>
#include <functional>

#include "app/server/site.hpp"

namespace livermark::server {

/// Times that the server waits for others.
struct Patience {
    /// After which the other side of a WebSocket is asked whether it is there, and given up without a sign of life.
    std::chrono::milliseconds silence = std::chrono::seconds(15);
    /// After which a session that waits for a message yields to a new one, where there are as many as may be.
    std::chrono::milliseconds until_replaced = std::chrono::seconds(10);
};

/// Answers requests to 127.0.0.1 until SIGINT or SIGTERM comes. Open WebSockets are closed then. Where one of them is
/// still working a reply out after a second, the whole program ends here, with status 0: a solve cannot be broken off,
/// and nothing that is worth keeping goes with it.
///
/// At most 64 connections and eight WebSockets are open at a time; one that has been silent, or does not take what is
/// sent, yields to a new one. Where the system has no descriptor left, new ones wait. Descriptors do not go to programs
/// that this one starts.
/// @param site      its port is the one to listen on; 0 takes any that is free
/// @param is_ready  called once, with the port, when requests are answered
/// @throws support::InputError if the port cannot be had
void serve(Site site, const std::function<void(std::uint16_t port)> &is_ready, const Patience &patience = {});

} // namespace livermark::server
