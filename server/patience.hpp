#pragma once

#include <chrono>

namespace livermark::server {

/// How long the server waits for others.
struct Patience {
    /// After which the other side of a WebSocket is asked whether it is there, and given up without a sign of life.
    std::chrono::milliseconds silence = std::chrono::seconds(15);
    /// After which a session that waits for a message yields to a new one, where there are as many as may be.
    std::chrono::milliseconds until_replaced = std::chrono::seconds(10);
};

} // namespace livermark::server
