#include "studies/cohort/body_numbers.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <string_view>

#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

constexpr int largest_number = 1000000;
constexpr std::size_t most_bodies = 1000;

[[noreturn]] void refuse(const std::string &text, const std::string &fault) {
    throw support::InputError(
        fmt::format("--bodies '{}': {}; give numbers from 1 to {} and ranges, {} at most, such as 1-8,12",
                    support::shown(text), fault, largest_number, most_bodies));
}

int number_of(std::string_view word, const std::string &text) {
    int number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc{} || end != word.data() + word.size() || number < 1 || number > largest_number)
        refuse(text, fmt::format("'{}' is not a number of a body", support::shown(word)));
    return number;
}

} // namespace

std::vector<int> body_numbers(const std::string &text) {
    std::vector<int> numbers;
    for (std::size_t start = 0; start <= text.size();) {
        const auto end = std::min(text.find(',', start), text.size());
        const auto part = std::string_view(text).substr(start, end - start);
        const auto dash = part.find('-');
        const int first = number_of(part.substr(0, dash), text);
        const int last = dash == std::string_view::npos ? first : number_of(part.substr(dash + 1), text);
        if (last < first)
            refuse(text, fmt::format("the range {} ends before it begins", part));
        if (numbers.size() + static_cast<std::size_t>(last - first) >= most_bodies)
            refuse(text, fmt::format("these are more than {} bodies", most_bodies));
        for (int number = first; number <= last; ++number)
            numbers.push_back(number);
        start = end + 1;
    }
    std::ranges::sort(numbers);
    if (const auto twice = std::ranges::adjacent_find(numbers); twice != numbers.end())
        refuse(text, fmt::format("{} is given twice", *twice));
    return numbers;
}

} // namespace livermark::studies
