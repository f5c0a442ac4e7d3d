#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/solution.hpp"

/// Enumerations whose values files hold as words. Internal to results/.
namespace livermark::results::hdf5 {

/// `all` is the array of the values of an enumeration; to_string() says the word of each.
template <class Value> struct Words;

template <> struct Words<core::Regime> { static constexpr std::array all{core::Regime::small, core::Regime::large}; };

template <> struct Words<core::SolutionStatus> {
    static constexpr std::array all{core::SolutionStatus::ok, core::SolutionStatus::diverged,
                                    core::SolutionStatus::not_converged};
};

/// The value that a word stands for; nothing if it stands for none.
template <class Value> std::optional<Value> value_of_word(const std::string &word) {
    const auto found =
        std::ranges::find_if(Words<Value>::all, [&](const Value value) { return word == to_string(value); });
    return found == Words<Value>::all.end() ? std::nullopt : std::optional(*found);
}

/// In the order of the enumeration.
template <class Value> std::vector<std::string> all_words() {
    std::vector<std::string> words;
    for (const Value value : Words<Value>::all)
        words.emplace_back(to_string(value));
    return words;
}

} // namespace livermark::results::hdf5
