#include "cli/word_order.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "models/model_table.hpp"
#include "msm/implicit_integrators.hpp"
#include "studies/catalogue.hpp"
#include "support/root_folder.hpp"

namespace livermark::cli {

namespace {

bool is_number(const std::string &word) {
    double value = 0.0;
    return CLI::detail::lexical_cast(word, value);
}

bool has_list_of_places(const CLI::App &command) {
    const auto is_list = [](const CLI::Option *option) {
        return option->get_positional() && option->get_items_expected_max() > 1;
    };
    return !command.get_options(is_list).empty();
}

const CLI::App *command_below(const CLI::App &command, const std::string &name) {
    const auto all = command.get_subcommands({});
    const auto found = std::ranges::find(all, name, [](const CLI::App *each) { return each->get_name(); });
    return found == all.end() ? nullptr : *found;
}

/// The option that a word names; none for words without a minus, and for unknown options.
const CLI::Option *option_of(const CLI::App &command, const std::string &word) {
    return word.size() > 1 && word.starts_with('-') ? command.get_option_no_throw(word.substr(0, word.find('=')))
                                                    : nullptr;
}

/// Whether the values of an option are bodies or paths themselves.
bool takes_places(const CLI::Option &option) {
    return std::ranges::any_of(std::array{"--body", "--load-case", "--surfaces"},
                               [&](const char *name) { return option.check_name(name); });
}

} // namespace

std::vector<std::string> with_places_first(const CLI::App &app, std::vector<std::string> words,
                                           const std::function<bool(const std::string &)> &is_place) {
    const CLI::App *command = &app;
    std::size_t first = 0;
    while (const auto *below = first < words.size() ? command_below(*command, words[first]) : nullptr) {
        command = below;
        ++first;
    }
    if (!has_list_of_places(*command))
        return words;
    std::vector<std::string> places, others;
    const CLI::Option *list = nullptr; // of which values come
    int num_values = 0;
    for (auto at = words.begin() + static_cast<std::ptrdiff_t>(first); at != words.end(); ++at) {
        if (*at == "--") { // from here on there are no options
            others.insert(others.end(), at, words.end());
            break;
        }
        if (at->size() > 1 && at->starts_with('-') && !is_number(*at)) {
            const auto *const option = option_of(*command, *at);
            list = option && option->get_items_expected_max() > 1 ? option : nullptr;
            num_values = at->find('=') == std::string::npos ? 0 : 1;
            others.push_back(*at);
        } else if (list && num_values > 0 &&
                   (num_values >= list->get_items_expected_max() ||
                    (!takes_places(*list) && !is_number(*at) && is_place(*at)))) {
            places.push_back(*at);
        } else {
            ++num_values;
            others.push_back(*at);
        }
    }
    words.resize(first);
    std::ranges::copy(places, std::back_inserter(words));
    std::ranges::copy(others, std::back_inserter(words));
    return words;
}

bool is_body_or_path(const std::string &word) {
    namespace fs = std::filesystem;
    const auto names = [&](const auto &table) {
        return std::ranges::any_of(table, [&](const auto &entry) { return entry.name == word; });
    };
    if (names(models::all_models()) || names(msm::known_integrators()))
        return false;
    std::error_code ignored;
    return fs::exists(word, ignored) ||
           (word.find('/') == std::string::npos &&
            fs::exists(support::root_folder() / studies::bodies_folder / (word + ".toml"), ignored));
}

} // namespace livermark::cli
