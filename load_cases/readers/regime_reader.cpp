#include "load_cases/readers/regime_reader.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <vector>

#include "support/input_error.hpp"

namespace livermark::load_cases {

namespace {

/// More would be frames of a motion, and fill disks.
constexpr std::size_t most_path_points = 50;

core::Regime regime_of(const toml::table &table) {
    if (!table.contains("regime"))
        return core::Regime::small;
    const auto word = support::required_string(table, "regime");
    for (const auto regime : {core::Regime::small, core::Regime::large})
        if (word == core::to_string(regime))
            return regime;
    throw support::InputError(fmt::format("{}: there is no regime '{}'; write \"small\" or \"large\"",
                                          support::place_of(*table.get("regime")), word));
}

/// The parts of the loads at which solutions are kept.
std::vector<double> read_path(const toml::table &table, core::Regime regime) {
    if (!table.contains("path"))
        return regime == core::Regime::large ? std::vector{0.2, 0.4, 0.6, 0.8, 1.0} : std::vector<double>{};
    const auto place = support::place_of(*table.get("path"));
    if (regime == core::Regime::small)
        throw support::InputError(fmt::format("{}: small deformations are proportional to the load and need no path; "
                                              "leave it out, or write regime = \"large\"",
                                              place));
    auto path = support::required_numbers(table, "path");
    const bool ascends = std::ranges::adjacent_find(path, std::greater_equal<>()) == path.end();
    if (path.size() < 2 || path.size() > most_path_points || !ascends || !(path.front() > 0.0) || path.back() != 1.0)
        throw support::InputError(fmt::format("{}: a path has 2 to {} parts of the load that ascend from above 0 to 1, "
                                              "such as [0.25, 0.5, 0.75, 1.0]",
                                              place, most_path_points));
    return path;
}

} // namespace

void read_regime(const toml::table &table, core::LoadCase &load_case) {
    load_case.regime = regime_of(table);
    load_case.path = read_path(table, load_case.regime);
}

} // namespace livermark::load_cases
