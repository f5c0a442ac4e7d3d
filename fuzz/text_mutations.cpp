#include <algorithm>
#include <cctype>
#include <cstring>
#include <fmt/format.h>
#include <iterator>
#include <string>
#include <vector>

#include "fuzz/absurd_values.hpp"
#include "fuzz/mutations.hpp"

namespace livermark::fuzz {

namespace {

using support::RandomNumbers;

struct Word {
    std::size_t begin, length;
};

/// Words, which whitespace and commas separate.
std::vector<Word> words_of(std::string_view text) {
    std::vector<Word> words;
    std::size_t begin = 0;
    for (std::size_t c = 0; c <= text.size(); ++c)
        if (c == text.size() || std::strchr(" \t\r\n,()=", text[c]) != nullptr) {
            if (c > begin)
                words.push_back({begin, c - begin});
            begin = c + 1;
        }
    return words;
}

bool is_number(std::string_view word) {
    return std::isdigit(static_cast<unsigned char>(word.back())) != 0 &&
           (std::isdigit(static_cast<unsigned char>(word.front())) != 0 || word.front() == '-' || word.front() == '.');
}

std::vector<std::string> lines_of(const std::string &text) {
    std::vector<std::string> lines;
    std::size_t begin = 0;
    while (begin < text.size()) {
        const auto end = std::min(text.find('\n', begin), text.size() - 1);
        lines.push_back(text.substr(begin, end + 1 - begin));
        begin = end + 1;
    }
    return lines;
}

std::string joined(const std::vector<std::string> &lines) {
    return fmt::format("{}", fmt::join(lines, ""));
}

std::string with_other_lines(const std::string &text, RandomNumbers &random) {
    auto lines = lines_of(text);
    if (lines.empty())
        return text;
    const auto first = some_of(lines.size(), random), second = some_of(lines.size(), random);
    switch (random.below(5)) {
    case 0:
        lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(first));
        break;
    case 1:
        std::swap(lines[first], lines[second]);
        break;
    case 2: {
        const std::size_t times = random.below(10) == 0 ? 5000 : 1;
        lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(first), times, std::string(lines[second]));
        break;
    }
    case 3:
        lines[first].resize(lines[first].size() - 1); // runs into the next one
        break;
    default:
        lines[first].insert(lines[first].size() - 1, random.below(2) == 0 ? "\r" : std::string(5000, 'x'));
    }
    return joined(lines);
}

std::string with_other_word(const std::string &text, RandomNumbers &random) {
    const auto words = words_of(text);
    if (words.empty())
        return text;
    std::vector<Word> numbers;
    std::ranges::copy_if(words, std::back_inserter(numbers),
                         [&](const Word &word) { return is_number(text.substr(word.begin, word.length)); });
    if (random.below(4) != 0 && !numbers.empty()) {
        const auto &[begin, length] = numbers[some_of(numbers.size(), random)];
        return text.substr(0, begin) + std::string(one_of(absurd_numbers, random)) + text.substr(begin + length);
    }
    const auto &[begin, length] = words[some_of(words.size(), random)];
    const auto &other = words[some_of(words.size(), random)];
    return text.substr(0, begin) + text.substr(other.begin, other.length) + text.substr(begin + length);
}

} // namespace

void damage_text(std::string &bytes, std::size_t length, RandomNumbers &random) {
    const auto text = bytes.substr(0, length);
    bytes.replace(0, length, random.below(3) == 0 ? with_other_lines(text, random) : with_other_word(text, random));
}

} // namespace livermark::fuzz
