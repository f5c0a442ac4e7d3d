#pragma once

#include <filesystem>

#include "server/conversation.hpp"

namespace livermark::app {

/// The springs of the live page in the native kernel: binary messages and replies are those of live::reply(), about the
/// body of a result file, held as open_live_body() says. Any text asks for the names of the spring laws.
/// @param folder  that is served; absolute, without symlinks and dots
/// @param query   `file=<path>`, of the server's list
/// @throws core::InputError for what open_live_body() refuses; the conversation, for what live::reply() does
server::Conversation live_springs(const std::filesystem::path &folder, const server::Fields &query);

} // namespace livermark::app
