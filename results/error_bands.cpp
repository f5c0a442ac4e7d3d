#include "results/error_bands.hpp"

#include <fmt/format.h>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "support/input_error.hpp"
#include "support/toml_input.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

constexpr std::string_view group_key = "group";
constexpr std::string_view origin_key = "origin";
constexpr std::string_view margin_key = "margin";
constexpr std::string_view value_key = "relative_l2";

const toml::table &table_of(const toml::node &node, std::string_view remedy) {
    if (const auto *table = node.as_table())
        return *table;
    throw support::InputError(fmt::format("{}: this has to be a table; {}", support::place_of(node), remedy));
}

/// What all bands of a group share.
ErrorBand read_head(const toml::table &group) {
    support::refuse_unknown_keys(group, {origin_key, margin_key, value_key});
    ErrorBand band{.margin = support::required_number(group, margin_key),
                   .origin = support::required_string(group, origin_key)};
    if (band.margin <= 0.0)
        throw support::InputError(fmt::format("{}: '{}' is not positive; give a number > 0",
                                              support::place_of(*group.get(margin_key)), margin_key));
    if (band.origin.empty())
        throw support::InputError(fmt::format("{}: '{}' is empty; say where the numbers come from",
                                              support::place_of(*group.get(origin_key)), origin_key));
    return band;
}

double read_expected(const toml::table &values, std::string_view load_case) {
    const double expected = support::required_number(values, load_case);
    if (expected < 0.0)
        throw support::InputError(fmt::format("{}: the error of '{}' is negative; give a number >= 0",
                                              support::place_of(*values.get(load_case)), load_case));
    return expected;
}

void add_band(ErrorBands &result, const BandKey &key, const ErrorBand &band, const std::string &place) {
    const auto [entry, is_new] = result.places.try_emplace(key, place);
    if (!is_new)
        throw support::InputError(fmt::format("{}: {} under {} has a band for {} already, at {}; keep one of them",
                                              place, key[0], key[1], key[2], entry->second));
    result.bands.emplace(key, band);
}

void add_group(ErrorBands &result, const toml::table &group) {
    auto band = read_head(group);
    for (const auto &[body, models] : support::required_table(group, value_key))
        for (const auto &[model, row] : table_of(models, "write [group.relative_l2.<body>] above the lines")) {
            const auto &values = table_of(row, "write <model> = {<load case> = <error>, ...}");
            for (const auto &[load_case, value] : values) {
                band.expected = read_expected(values, load_case);
                add_band(result, {std::string(body.str()), std::string(load_case.str()), std::string(model.str())},
                         band, support::place_of(value));
            }
        }
}

std::string quoted(const std::string &text) {
    // On one line, so that each band keeps a line that messages can name.
    constexpr auto form = toml::toml_formatter::default_flags & ~toml::format_flags::allow_multi_line_strings;
    const toml::value<std::string> value(text);
    std::ostringstream stream;
    stream << toml::toml_formatter(value, form);
    return stream.str();
}

std::string key_text(const std::string &name) {
    const bool is_bare = !name.empty() && name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                                                 "0123456789_-") == std::string::npos;
    return is_bare ? name : quoted(name);
}

using Row = std::map<std::string, double>; // expected values by load case

/// toml++ as Debian has it writes 0.1457 with 17 digits; fmt writes the shortest number that is read back as the same.
std::string row_text(const std::string &model, const Row &row) {
    std::vector<std::string> values;
    for (const auto &[load_case, expected] : row)
        values.push_back(fmt::format("{} = {}", key_text(load_case), expected));
    return fmt::format("{} = {{ {} }}\n", key_text(model), fmt::join(values, ", "));
}

} // namespace

std::optional<ErrorBand> ErrorBands::find(const std::string &body, const std::string &load_case,
                                          const std::string &model) const {
    const auto found = bands.find({body, load_case, model});
    return found == bands.end() ? std::nullopt : std::optional(found->second);
}

ErrorBands read_error_bands(const std::filesystem::path &path) {
    constexpr auto remedy = "write [[group]] above origin, margin and the tables of bodies";
    const auto document = support::parse_toml(support::read_text(path), path);
    support::refuse_unknown_keys(document, {group_key});
    ErrorBands result;
    const auto *groups = document.get(group_key);
    if (!groups)
        return result;
    if (!groups->is_array())
        throw support::InputError(fmt::format("{}: a group is no list; {}", support::place_of(*groups), remedy));
    for (const auto &group : *groups->as_array())
        add_group(result, table_of(group, remedy));
    return result;
}

std::string to_toml(const std::map<BandKey, ErrorBand> &bands) {
    std::map<std::pair<std::string, double>, std::map<std::string, std::map<std::string, Row>>> groups;
    for (const auto &[key, band] : bands) {
        const auto &[body, load_case, model] = key;
        groups[{band.origin, band.margin}][body][model][load_case] = band.expected;
    }
    std::string text;
    for (const auto &[head, bodies] : groups) {
        text += fmt::format("{}[[group]]\norigin = {}\nmargin = {}\n", text.empty() ? "" : "\n", quoted(head.first),
                            head.second);
        for (const auto &[body, rows] : bodies) {
            text += fmt::format("\n[group.{}.{}]\n", value_key, key_text(body));
            for (const auto &[model, row] : rows)
                text += row_text(model, row);
        }
    }
    return text;
}

} // namespace livermark::results
