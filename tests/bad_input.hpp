#pragma once

#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "core/support/input_error.hpp"

namespace livermark::tests {

/// Runs something on bad input: it has to throw an InputError whose message has every one of these parts, in one line.
template <typename Action> void expect_input_error(Action &&action, const std::vector<std::string> &parts) {
    try {
        action();
        ADD_FAILURE() << "the bad input was accepted; expected '" << parts.front() << "'";
    } catch (const support::InputError &error) {
        const std::string message = error.what();
        for (const auto &part : parts)
            EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is missing in: " << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
}

} // namespace livermark::tests
