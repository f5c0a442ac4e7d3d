#include "results/error_bands.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <toml++/toml.h>

#include "core/input_error.hpp"

namespace livermark::results {

namespace {

constexpr std::array<std::string_view, 3> band_keys{"relative_l2", "margin", "origin"};

/// Where in the file the reader is.
struct Place {
    std::string file;
    std::string table; ///< "<body>.<load case>.<model>" or the part of it that was reached

    [[noreturn]] void refuse(const toml::node &node, const std::string &fault) const {
        throw core::InputError(fmt::format("{}:{}: {}", file, node.source().begin.line, fault));
    }
};

const toml::table &table_of(const toml::node &node, const Place &place) {
    if (const toml::table *table = node.as_table())
        return *table;
    place.refuse(node,
                 fmt::format("{} is not a table; write [<body>.<load case>.<model>] above its lines", place.table));
}

double number(const toml::table &table, std::string_view key, const Place &place) {
    const toml::node *node = table.get(key);
    if (node == nullptr)
        place.refuse(table, fmt::format("[{}] has no {}; add '{} = <number>'", place.table, key, key));
    // A boolean is no number, and toml++ would convert it.
    const auto value = node->is_number() ? node->value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value))
        place.refuse(*node,
                     fmt::format("{} in [{}] is not a finite number; write '{} = <number>'", key, place.table, key));
    return *value;
}

ErrorBand read_band(const toml::table &table, const Place &place) {
    for (const auto &[key, node] : table)
        if (std::ranges::find(band_keys, key.str()) == band_keys.end())
            place.refuse(node, fmt::format("[{}] has an unknown key {}; use {}", place.table, key.str(),
                                           fmt::join(band_keys, ", ")));
    ErrorBand band;
    band.expected = number(table, "relative_l2", place);
    if (band.expected < 0.0)
        place.refuse(*table.get("relative_l2"),
                     fmt::format("relative_l2 in [{}] is negative; give a number >= 0", place.table));
    band.margin = number(table, "margin", place);
    if (band.margin <= 0.0)
        place.refuse(*table.get("margin"),
                     fmt::format("margin in [{}] is not positive; give a number > 0", place.table));
    const toml::node *origin = table.get("origin");
    band.origin = origin == nullptr ? "" : origin->value<std::string>().value_or("");
    if (band.origin.empty())
        place.refuse(origin == nullptr ? table : *origin,
                     fmt::format("[{}] has no text for origin; say where relative_l2 comes from, 'origin = \"...\"'",
                                 place.table));
    return band;
}

toml::table parse(const std::string &file) {
    try {
        return toml::parse_file(file);
    } catch (const toml::parse_error &error) {
        const auto line = error.source().begin.line;
        throw core::InputError(
            line > 0
                ? fmt::format("{}:{}: not valid TOML: {}; correct this line", file, line, error.description())
                : fmt::format("{}: cannot be read as TOML: {}; check that the file exists", file, error.description()));
    }
}

} // namespace

std::optional<ErrorBand> ErrorBands::find(const std::string &body, const std::string &load_case,
                                          const std::string &model) const {
    const auto found = bands.find({body, load_case, model});
    return found == bands.end() ? std::nullopt : std::optional(found->second);
}

ErrorBands read_error_bands(const std::filesystem::path &path) {
    const std::string file = path.string();
    const toml::table document = parse(file);
    ErrorBands result;
    for (const auto &[body, body_node] : document) {
        const Place in_body{file, std::string(body.str())};
        for (const auto &[load_case, load_case_node] : table_of(body_node, in_body)) {
            const Place in_load_case{file, fmt::format("{}.{}", in_body.table, load_case.str())};
            for (const auto &[model, model_node] : table_of(load_case_node, in_load_case)) {
                const Place in_model{file, fmt::format("{}.{}", in_load_case.table, model.str())};
                result.bands[{std::string(body.str()), std::string(load_case.str()), std::string(model.str())}] =
                    read_band(table_of(model_node, in_model), in_model);
            }
        }
    }
    return result;
}

} // namespace livermark::results
