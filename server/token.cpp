#include "server/token.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <random>

namespace livermark::server {

namespace {

std::string cookie_name(std::uint16_t port) {
    return fmt::format("livermark_{}", port);
}

} // namespace

std::string new_token() {
    static_assert(std::random_device::min() == 0 && std::random_device::max() == 0xffffffffU);
    constexpr int num_words = 4;
    std::random_device words;
    std::string token;
    for (int i = 0; i < num_words; ++i)
        token += fmt::format("{:08x}", words());
    return token;
}

bool is_same(std::string_view one, std::string_view other) {
    unsigned difference = one.size() == other.size() ? 0U : 1U;
    for (std::size_t i = 0; i < std::min(one.size(), other.size()); ++i)
        difference |= static_cast<unsigned>(static_cast<unsigned char>(one[i]) ^ static_cast<unsigned char>(other[i]));
    return difference == 0U;
}

bool cookie_has_token(std::string_view cookies, std::uint16_t port, std::string_view token) {
    const auto start = cookie_name(port) + '=';
    while (!cookies.empty()) {
        auto cookie = cookies.substr(0, cookies.find(';'));
        cookies.remove_prefix(std::min(cookie.size() + 1, cookies.size()));
        cookie.remove_prefix(std::min(cookie.find_first_not_of(' '), cookie.size()));
        // Another server of this host may have set one of the same name; it is not for it to say who comes in here.
        if (cookie.starts_with(start) && is_same(cookie.substr(start.size()), token))
            return true;
    }
    return false;
}

std::string cookie_of_token(std::uint16_t port, std::string_view token) {
    return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict", cookie_name(port), token);
}

} // namespace livermark::server
