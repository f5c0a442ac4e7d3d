#include "core/support/input_error.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <numeric>

namespace livermark::support {

std::string shown(std::string_view text) {
    constexpr std::size_t longest = 30;
    std::string result(text.substr(0, longest));
    std::ranges::replace_if(
        result, [](char c) { return std::isprint(static_cast<unsigned char>(c)) == 0; }, '?');
    return text.size() > longest ? result + "..." : result;
}

namespace {

/// Levenshtein's distance: how many letters to insert, delete or replace.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = row[0]++;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

} // namespace

std::string nearest_word(std::string_view word, const std::vector<std::string> &known) {
    std::string nearest;
    std::size_t smallest = std::max<std::size_t>(2, word.size() / 3) + 1;
    for (const auto &candidate : known)
        if (const auto distance = edit_distance(word, candidate); distance < smallest) {
            smallest = distance;
            nearest = candidate;
        }
    return nearest;
}

std::string unknown_name(const char *word, const std::string &name, const std::vector<std::string> &known) {
    constexpr std::size_t most_to_name = 30; // more than that nobody reads in a message
    const auto nearest = nearest_word(name, known);
    const std::string_view what = word, noun = what.substr(0, what.find(" that "));
    const auto remedy =
        !nearest.empty()               ? fmt::format("did you mean '{}'?", nearest)
        : known.size() <= most_to_name ? fmt::format("known are: {}", fmt::join(known, ", "))
        : noun == what ? fmt::format("'livermark list {}s' prints the {} that are known", noun, known.size())
                       : fmt::format("'livermark list {}s' prints all {}s, and {} are such", noun, noun, known.size());
    return fmt::format("there is no {} '{}'; {}", word, name, remedy);
}

} // namespace livermark::support
