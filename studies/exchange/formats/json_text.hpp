#pragma once

#include <cmath>
#include <fmt/format.h>
#include <string>

namespace livermark::exchange {

// Values as JSON, for long arrays: one line, the shortest digits that give the same number again.

inline std::string json(double value) {
    return std::isnan(value) ? "NaN" : fmt::format("{}", value); // as Python reads and writes it
}

inline std::string json(int value) {
    return fmt::format("{}", value);
}

inline std::string json(const std::string &text) {
    std::string quoted = "\"";
    for (const char c : text)
        if (const auto byte = static_cast<unsigned char>(c); byte < 0x20)
            quoted += fmt::format("\\u{:04x}", byte);
        else
            quoted += c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
    return quoted + '"';
}

template <class Values> std::string json(const Values &values) {
    std::string text;
    for (const auto &value : values)
        text += (text.empty() ? "" : ",") + json(value);
    return '[' + text + ']';
}

} // namespace livermark::exchange
