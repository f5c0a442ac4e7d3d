#pragma once

#include <algorithm>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "core/support/input_error.hpp"

namespace livermark::tests {

/// A text has to have a part.
inline void expect_part(const std::string &text, const std::string &part) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is missing in: " << text;
}

/// There has to be one remark, which has a part.
inline void expect_one(const std::vector<std::string> &remarks, const std::string &part) {
    ASSERT_EQ(remarks.size(), 1U);
    expect_part(remarks[0], part);
}

/// Runs something on bad input: it has to throw an InputError whose message has every one of these parts, in one line.
template <typename Action> void expect_input_error(Action &&action, const std::vector<std::string> &parts) {
    try {
        action();
        ADD_FAILURE() << "the bad input was accepted; expected '" << parts.front() << "'";
    } catch (const support::InputError &error) {
        const std::string message = error.what();
        for (const auto &part : parts)
            expect_part(message, part);
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
}

/// A text with something else in the place of a part, which it has to have.
inline std::string replaced(std::string text, const std::string &part, const std::string &by) {
    const auto at = text.find(part);
    EXPECT_NE(at, std::string::npos) << part;
    return at == std::string::npos ? text : text.replace(at, part.size(), by);
}

inline constexpr std::size_t longest_in_golden_file = 120; ///< letters that a reviewer reads in one line

/// Two lines of a golden file of refusals: what is wrong, and the sentence of the InputError that it has to bring.
/// @param folder  of the files, left out of the sentence
template <typename Action> std::string refusal(std::string wrong, Action &&action, const std::string &folder = {}) {
    std::ranges::replace(wrong, '\n', ' ');
    wrong.erase(wrong.find_last_not_of(' ') + 1);
    if (wrong.size() > longest_in_golden_file)
        wrong = wrong.substr(0, longest_in_golden_file / 2) + " ... " +
                wrong.substr(wrong.size() - longest_in_golden_file / 2);
    try {
        action();
        ADD_FAILURE() << "this was accepted: " << wrong;
        return {};
    } catch (const support::InputError &error) {
        std::string sentence = error.what();
        EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
        for (auto at = folder.empty() ? std::string::npos : sentence.find(folder); at != std::string::npos;
             at = sentence.find(folder, at))
            sentence.erase(at, folder.size() + 1);
        return wrong + "\n    " + sentence + "\n";
    }
}

/// Rows for the refusals of a text after each of some changes.
/// @param changes  "part -> what stands in its place"
template <typename Read>
std::string refusals_after(const std::vector<std::string> &changes, const std::string &text, const Read &read,
                           const std::string &folder = {}) {
    std::string rows;
    for (const auto &change : changes) {
        const auto at = change.find(" -> ");
        rows += refusal(
            change, [&] { read(replaced(text, change.substr(0, at), change.substr(at + 4))); }, folder);
    }
    return rows;
}

} // namespace livermark::tests
