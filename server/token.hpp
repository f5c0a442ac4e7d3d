#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// What tells who may ask a server from everybody else on this machine: a token in the address that it prints, which
/// the first visit turns into a cookie.
namespace livermark::server {

/// 128 random bits of the system's generator, as 32 hexadecimal digits.
std::string new_token();

/// Whether two texts are the same, in a time that does not say where they differ.
bool is_same(std::string_view one, std::string_view other);

/// Whether the value of a Cookie header has the token of the server at a port. Browsers keep cookies by host and not
/// by port, so the cookie's name has the port: several servers on one machine do not take theirs from each other.
/// What another program of this machine has a browser visit is sent the cookie as well: do not follow addresses of
/// 127.0.0.1 that are not yours.
bool cookie_has_token(std::string_view cookies, std::uint16_t port, std::string_view token);

/// The value of the Set-Cookie header: no script may read it, and no other site has it sent.
std::string cookie_of_token(std::uint16_t port, std::string_view token);

} // namespace livermark::server
