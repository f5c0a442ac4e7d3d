#pragma once

#include <filesystem>

#include "app/server/session.hpp"

namespace livermark::server {

/// The springs of the live page in the native kernel: binary messages and replies are those of live::reply(), about the
/// body of a result file, constrained as open_live_body() says. Any text asks for the names of the springs.
/// @param folder  that is served; absolute, without symlinks and dots
/// @param query   `file=<path>`, of the server's list
/// @throws support::InputError for what open_live_body() refuses; the session, for what live::reply() does
Session live_springs(const std::filesystem::path &folder, const Fields &query);

} // namespace livermark::server
