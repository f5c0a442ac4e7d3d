#include "cli/usage.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <sstream>

#include "support/input_error.hpp"
#include "support/known_names.hpp"

namespace livermark::cli {

namespace {

std::vector<std::string> subcommand_names(const CLI::App &app) {
    std::vector<std::string> names;
    for (const auto *subcommand : app.get_subcommands({}))
        names.push_back(subcommand->get_name());
    return names;
}

std::vector<std::string> option_names(const CLI::App &app) {
    std::vector<std::string> names;
    for (const auto *option : app.get_options())
        for (const auto &name : option->get_lnames())
            names.push_back("--" + name);
    return names;
}

/// The subcommand that the words have come to.
const CLI::App &last_command(const CLI::App &app) {
    const auto parsed = app.get_subcommands();
    return parsed.empty() ? app : last_command(*parsed.back());
}

std::string full_name(const CLI::App &app) {
    return app.get_parent() ? fmt::format("{} {}", full_name(*app.get_parent()), app.get_name()) : app.get_name();
}

std::string about_unexpected(const std::string &word, const CLI::App &command) {
    if (!word.starts_with('-'))
        return fmt::format("'{}' is one word too many; leave it out, or see `{} --help`", word, full_name(command));
    const auto name = word.substr(0, word.find('='));
    const auto nearest = support::nearest_word(name, option_names(command));
    return fmt::format("`{}` has no option '{}'; {}", full_name(command), name,
                       nearest.empty() ? fmt::format("see `{} --help`", full_name(command))
                                       : fmt::format("did you mean '{}'?", nearest));
}

/// @param description  stands in --help
CLI::Validator number_where(bool (*is_good)(double), const char *wanted, const char *description) {
    return {[=](const std::string &text) {
                double value = 0.0;
                return CLI::detail::lexical_cast(text, value) && is_good(value)
                           ? std::string()
                           : fmt::format("'{}' has to be a finite number {}", text, wanted);
            },
            description, ""};
}

/// Help in which an option that is also an argument refers to the argument.
class ArgumentsOnce : public CLI::Formatter {
  public:
    std::string make_option(const CLI::Option *option, bool is_positional) const override {
        if (is_positional || !option->get_positional())
            return CLI::Formatter::make_option(option, is_positional);
        std::ostringstream text;
        CLI::detail::format_help(text, make_option_name(option, false) + make_option_opts(option),
                                 fmt::format("As the argument {}", option->get_name(true)), get_column_width());
        return text.str();
    }
};

} // namespace

void describe_arguments_once(CLI::App &app) {
    app.formatter(std::make_shared<ArgumentsOnce>());
}

void refuse_empty_places(CLI::App &app) {
    for (const auto *const name : {"--output", "--picture", "--scan"})
        if (auto *option = app.get_option_no_throw(name))
            option->check(CLI::Validator(
                [](const std::string &place) {
                    return place.empty() ? std::string("the name is empty; give one, or leave the option out")
                                         : std::string();
                },
                ""));
    for (auto *subcommand : app.get_subcommands({}))
        refuse_empty_places(*subcommand);
}

void refuse_unknown_subcommand(const CLI::App &app, const std::vector<std::string> &words) {
    const auto known = subcommand_names(app);
    if (known.empty() || words.empty() || words.front().starts_with('-'))
        return;
    if (std::ranges::find(known, words.front()) == known.end())
        throw support::InputError(support::unknown_name("subcommand", words.front(), known));
    refuse_unknown_subcommand(*app.get_subcommand(words.front()), {words.begin() + 1, words.end()});
}

std::string usage_sentence(const CLI::App &app, const CLI::ParseError &error) {
    const auto &command = last_command(app);
    const auto unexpected = app.remaining(true);
    const auto is_option = [](const std::string &word) { return word.starts_with('-'); };
    // What is missing may be missing because of a slip here, so this comes first.
    if (const auto option = std::ranges::find_if(unexpected, is_option); option != unexpected.end())
        return about_unexpected(*option, command);
    if (dynamic_cast<const CLI::ValidationError *>(&error)) // checks say what would be right
        return error.what();
    if (const auto names = subcommand_names(command); !names.empty())
        return fmt::format("a subcommand is missing behind `{}`; give one of {}", full_name(command),
                           fmt::join(names, ", "));
    if (!unexpected.empty())
        return about_unexpected(unexpected.front(), command);
    return fmt::format("{}; see `{} --help`", error.what(), full_name(command));
}

CLI::Validator positive_number() {
    return number_where([](double value) { return value > 0.0 && std::isfinite(value); }, "above zero", "POSITIVE");
}

CLI::Validator number_not_below_zero() {
    return number_where([](double value) { return value >= 0.0 && std::isfinite(value); }, "of zero or more",
                        "NONNEGATIVE");
}

CLI::Validator one_of(const std::vector<std::string> &known) {
    return {[=](const std::string &text) {
                const auto word = CLI::detail::to_lower(text);
                return std::ranges::find(known, word) != known.end() ? std::string()
                                                                     : support::unknown_name("choice", text, known);
            },
            fmt::format("{{{}}}", fmt::join(known, ",")), ""};
}

} // namespace livermark::cli
