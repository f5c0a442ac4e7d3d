#pragma once

#include <cstdint>
#include <functional>

#include "server/site.hpp"

namespace livermark::server {

/// Answers requests to 127.0.0.1 until SIGINT or SIGTERM comes.
/// @param site      its port is the one to listen on; 0 takes any that is free
/// @param is_ready  called once, with the port, when requests are answered
/// @throws core::InputError if the port cannot be had
void serve(Site site, const std::function<void(std::uint16_t port)> &is_ready);

} // namespace livermark::server
