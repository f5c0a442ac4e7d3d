#pragma once

#include <functional>
#include <string>

#include "server/fields.hpp"

namespace livermark::server {

/// Of a WebSocket.
struct Message {
    bool is_binary = false; ///< else UTF-8
    std::string bytes;
};

/// Replies to a message. What the other side did wrong is a support::InputError, which goes out as the text
/// `fault=<sentence>`, and the session goes on; any other exception closes the socket. It stays in one thread,
/// while other sessions, and the pages, are served by theirs.
using Session = std::function<Message(const Message &)>;

/// Reports to the other side what a reply is waiting for, as the text `progress=<sentence>` before it: any number of
/// them, which are no replies. Only while a session begins or works out a reply, and in its thread.
using ReportProgress = std::function<void(const std::string &sentence)>;

/// Begins a session from the query of its address, in the thread in which it will stay. A support::InputError is the
/// reply to every message then: browsers do not show why a WebSocket was refused.
/// @param report  lives as long as the session
using BeginSession = std::function<Session(const Fields &query, const ReportProgress &report)>;

} // namespace livermark::server
