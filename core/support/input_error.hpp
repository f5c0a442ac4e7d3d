#pragma once

#include <algorithm>
#include <ranges>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace livermark::support {

/// Something that came in from outside is wrong: the message says what, where and the remedy in one sentence, and the
/// command ends with exit status 2. Every other exception is a fault of ours or of the machine.
class InputError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// A piece of a damaged file as a message can show it: printable, and not longer than a few words.
std::string shown(std::string_view text);

/// The known word nearest to a misspelt one, or an empty string where nothing is near.
std::string nearest_word(std::string_view word, const std::vector<std::string> &known);

/// A sentence for a name that is not among the known ones.
/// @param word  what the names are of
std::string unknown_name(const char *word, const std::string &name, const std::vector<std::string> &known);

/// Names of the entries of a table.
template <std::ranges::input_range Table> std::vector<std::string> names_of(const Table &table) {
    std::vector<std::string> names;
    for (const auto &entry : table)
        names.push_back(entry.name);
    return names;
}

/// The entry of that name, of a table that outlives the call.
/// @param word  what the entries are
/// @throws InputError if there is none
template <std::ranges::forward_range Table>
const auto &find_named(const Table &table, const std::string &name, const char *word) {
    const auto found = std::ranges::find_if(table, [&](const auto &entry) { return entry.name == name; });
    if (found == std::ranges::end(table))
        throw InputError(unknown_name(word, name, names_of(table)));
    return *found;
}

} // namespace livermark::support
