#include "support/input_error.hpp"

#include <algorithm>
#include <cctype>

namespace livermark::support {

std::string shown(std::string_view text) {
    constexpr std::size_t longest = 30;
    std::string result(text.substr(0, longest));
    std::ranges::replace_if(
        result, [](char c) { return std::isprint(static_cast<unsigned char>(c)) == 0; }, '?');
    return text.size() > longest ? result + "..." : result;
}

} // namespace livermark::support
