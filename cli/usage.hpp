#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

/// Faults of the command line as one sentence with the remedy, where CLI11 would take several lines, show numbers of
/// its own or name the largest double in full.
namespace livermark::cli {

/// Refuses a word in the place of a subcommand that is none, and names the nearest one.
/// @throws support::InputError
void refuse_unknown_subcommand(const CLI::App &app, const std::vector<std::string> &words);

/// Lets the help describe an argument once that is also an option, such as body and --body. Subcommands that are added
/// later inherit it.
void describe_arguments_once(CLI::App &app);

/// Lets every option that names a place to write to, such as --output, refuse an empty name. Called when all commands
/// are there.
void refuse_empty_places(CLI::App &app);

/// The sentence for a command line that CLI11 has refused.
std::string usage_sentence(const CLI::App &app, const CLI::ParseError &error);

/// Checks for options that take numbers.
CLI::Validator positive_number();
CLI::Validator number_not_below_zero();

/// Lets an option be one of some words.
/// @param known  in lower case
CLI::Validator one_of(const std::vector<std::string> &known);

/// The same for an option that is an enumeration: word by word, what it stands for.
template <class Enumeration> CLI::Validator one_of(const std::map<std::string, Enumeration> &values) {
    std::vector<std::string> known;
    std::map<std::string, std::string> number_of;
    for (const auto &[word, value] : values) {
        known.push_back(word);
        number_of[word] = std::to_string(static_cast<int>(value));
    }
    auto validator = one_of(known);
    const auto check = validator;
    return validator.operation([=](std::string &text) {
        auto fault = check(text);
        if (fault.empty())
            text = number_of.at(CLI::detail::to_lower(text));
        return fault;
    });
}

} // namespace livermark::cli
