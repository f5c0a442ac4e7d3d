#include "results/error_bands.hpp"

#include <fmt/format.h>

#include "core/input_error.hpp"
#include "core/toml_input.hpp"

namespace livermark::results {

namespace {

const toml::table &table_of(const toml::node &node) {
    if (const auto *table = node.as_table())
        return *table;
    throw core::InputError(fmt::format("{}: bands stand in tables; write [<body>.<load case>.<model>] above the lines",
                                       core::place_of(node)));
}

ErrorBand read_band(const toml::table &table) {
    core::refuse_unknown_keys(table, {"relative_l2", "margin", "origin"});
    ErrorBand band{.expected = core::required_number(table, "relative_l2"),
                   .margin = core::required_number(table, "margin"),
                   .origin = core::required_string(table, "origin")};
    if (band.expected < 0.0)
        throw core::InputError(fmt::format("{}: 'relative_l2' is negative; give a number >= 0",
                                           core::place_of(*table.get("relative_l2"))));
    if (band.margin <= 0.0)
        throw core::InputError(
            fmt::format("{}: 'margin' is not positive; give a number > 0", core::place_of(*table.get("margin"))));
    if (band.origin.empty())
        throw core::InputError(fmt::format("{}: 'origin' is empty; say where relative_l2 comes from",
                                           core::place_of(*table.get("origin"))));
    return band;
}

} // namespace

std::optional<ErrorBand> ErrorBands::find(const std::string &body, const std::string &load_case,
                                          const std::string &model) const {
    const auto found = bands.find({body, load_case, model});
    return found == bands.end() ? std::nullopt : std::optional(found->second);
}

ErrorBands read_error_bands(const std::filesystem::path &path) {
    ErrorBands result;
    const auto document = core::parse_toml(core::read_text(path), path);
    for (const auto &[body, load_cases] : document)
        for (const auto &[load_case, models] : table_of(load_cases))
            for (const auto &[model, band] : table_of(models))
                result.bands[{std::string(body.str()), std::string(load_case.str()), std::string(model.str())}] =
                    read_band(table_of(band));
    return result;
}

} // namespace livermark::results
