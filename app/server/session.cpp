#include "app/server/session.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <system_error>

#include "core/support/input_error.hpp"

namespace livermark::server {

namespace {

std::string decoded(std::string_view text) {
    std::string with_spaces(text);
    std::ranges::replace(with_spaces, '+', ' ');
    const auto plain = percent_decoded(with_spaces);
    if (!plain)
        throw support::InputError(fmt::format(
            "'{}' has a % that two hexadecimal digits do not follow; write %25 for it", support::shown(text)));
    return *plain;
}

std::string encoded(std::string_view text) {
    constexpr std::string_view kept = "*-._";
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == ' ')
            out += '+';
        else if (byte < 0x80 && (std::isalnum(byte) != 0 || kept.find(c) != std::string_view::npos))
            out += c;
        else
            out += fmt::format("%{:02X}", byte);
    }
    return out;
}

} // namespace

std::optional<std::string> percent_decoded(std::string_view text) {
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            decoded += text[i];
            continue;
        }
        unsigned value = 0;
        const auto *digits = text.data() + i + 1;
        if (i + 2 >= text.size() || std::from_chars(digits, digits + 2, value, 16).ptr != digits + 2)
            return std::nullopt;
        decoded += static_cast<char>(value);
        i += 2;
    }
    return decoded;
}

Fields parse_fields(std::string_view text) {
    Fields fields;
    while (!text.empty()) {
        const auto part = text.substr(0, text.find('&'));
        text.remove_prefix(std::min(part.size() + 1, text.size()));
        if (part.empty())
            continue;
        const auto equals = std::min(part.find('='), part.size());
        const auto name = decoded(part.substr(0, equals));
        const auto value = decoded(part.substr(std::min(equals + 1, part.size())));
        if (!fields.emplace(name, value).second)
            throw support::InputError(fmt::format("'{}' is given twice; give it once", support::shown(name)));
    }
    return fields;
}

std::string fields_text(const Fields &fields) {
    std::string text;
    for (const auto &[name, value] : fields)
        text += fmt::format("{}{}={}", text.empty() ? "" : "&", encoded(name), encoded(value));
    return text;
}

const std::string &required_text(const Fields &fields, const std::string &name) {
    const auto found = fields.find(name);
    if (found == fields.end() || found->second.empty())
        throw support::InputError(fmt::format("{0} is missing; add {0}=...", name));
    return found->second;
}

double required_number(const Fields &fields, const std::string &name, double smallest, double largest) {
    const auto &text = required_text(fields, name);
    double value = 0.0;
    const auto *end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, value);
    // Written so that a NaN, which from_chars reads, is refused as well.
    if (error != std::errc{} || rest != end || !(value >= smallest && value <= largest))
        throw support::InputError(fmt::format("{} is '{}', which is no number from {:g} to {:g}; give one that is",
                                              name, support::shown(text), smallest, largest));
    return value;
}

std::vector<double> required_numbers(const Fields &fields, const std::string &name) {
    std::string_view text = required_text(fields, name);
    std::vector<double> values;
    while (true) {
        const auto word = text.substr(0, text.find(','));
        double value = 0.0;
        const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc{} || rest != word.data() + word.size() || !std::isfinite(value))
            throw support::InputError(fmt::format("{} has '{}', where a finite number belongs; send numbers with "
                                                  "commas between them",
                                                  name, support::shown(word)));
        values.push_back(value);
        if (word.size() == text.size())
            return values;
        text.remove_prefix(word.size() + 1);
    }
}

} // namespace livermark::server
