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

/// Replies to a message. What the other side did wrong is a core::InputError, which goes out as the text
/// `fault=<sentence>`, and the conversation goes on; any other exception closes the socket. It stays in one thread,
/// while other conversations, and the pages, are served by theirs.
using Conversation = std::function<Message(const Message &)>;

/// Begins a conversation from the query of its address, in the thread in which it will stay. A core::InputError is the
/// reply to every message then: browsers do not show why a WebSocket was refused.
using BeginConversation = std::function<Conversation(const Fields &query)>;

} // namespace livermark::server
