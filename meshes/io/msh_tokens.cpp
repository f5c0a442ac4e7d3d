#include "meshes/io/msh_tokens.hpp"

#include <cctype>
#include <charconv>
#include <fmt/format.h>
#include <limits>

#include "support/input_error.hpp"

namespace livermark::meshes {

namespace {

bool is_space(char c) {
    return std::isspace(static_cast<unsigned char>(c)) != 0;
}

/// Reads all of a word. Some programs write a plus sign, which from_chars does not know.
template <class Number> bool is_read(std::string_view text, Number &value) {
    if (text.size() > 1 && text[0] == '+' && text[1] != '-')
        text.remove_prefix(1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size();
}

} // namespace

void MshTokens::fail(const std::string &what) const {
    throw support::InputError(fmt::format("{}:{}: {}", file_, line_, what));
}

bool MshTokens::at_word() {
    while (position_ < text_.size() && is_space(text_[position_]))
        line_ += text_[position_++] == '\n';
    return position_ < text_.size();
}

std::string_view MshTokens::word() {
    if (!at_word())
        fail("the file ends too early; save it again");
    const auto start = position_;
    while (position_ < text_.size() && !is_space(text_[position_]))
        ++position_;
    return text_.substr(start, position_ - start);
}

std::string MshTokens::quoted() {
    if (!at_word() || text_[position_] != '"')
        fail("a name in quotes has to stand here");
    const auto end = text_.find_first_of("\"\n", position_ + 1);
    if (end == std::string_view::npos || text_[end] != '"')
        fail("a name in quotes does not end; close the quotes");
    const auto name = text_.substr(position_ + 1, end - position_ - 1);
    position_ = end + 1;
    return std::string(name);
}

std::int64_t MshTokens::integer() {
    const auto text = word();
    std::int64_t value = 0;
    if (!is_read(text, value))
        fail(fmt::format("'{}' has to be an integer", support::shown(text)));
    return value;
}

int MshTokens::count(int smallest) {
    const auto value = integer();
    if (value < smallest || value > std::numeric_limits<int>::max())
        fail(fmt::format("{} is out of range here; give a number from {} to {}", value, smallest,
                         std::numeric_limits<int>::max()));
    return static_cast<int>(value);
}

double MshTokens::number() {
    const auto text = word();
    double value = 0.0;
    if (!is_read(text, value))
        fail(fmt::format("'{}' has to be a number", support::shown(text)));
    return value;
}

void MshTokens::expect(std::string_view wanted) {
    if (const auto found = word(); found != wanted)
        fail(fmt::format("'{}' has to stand here, not '{}'", wanted, support::shown(found)));
}

void MshTokens::skip_words(std::int64_t num_words) {
    for (std::int64_t w = 0; w < num_words; ++w)
        word();
}

void MshTokens::skip_to(std::string_view wanted) {
    while (word() != wanted) {
    }
}

} // namespace livermark::meshes
