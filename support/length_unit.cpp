#include "support/length_unit.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <system_error>

#include "support/input_error.hpp"

namespace livermark::support {

namespace {

/// From a nanometre to a kilometre: squares of lengths in it are numbers.
bool can_be_a_unit(double metres) {
    return metres >= 1e-9 && metres <= 1e3;
}

} // namespace

double metres_per_unit(const std::string &unit, const std::string &place) {
    const auto *known = std::ranges::find(length_units, unit, &std::pair<std::string_view, double>::first);
    if (known != length_units.end())
        return known->second;
    double metres = 0.0;
    const auto [end, error] = std::from_chars(unit.data(), unit.data() + unit.size(), metres);
    if (error != std::errc{} || end != unit.data() + unit.size() || !(metres > 0.0 && std::isfinite(metres)))
        throw InputError(
            fmt::format("{}: '{}' is not a unit of length; give m, cm or mm, or its length in metres, such as 0.025",
                        place, shown(unit)));
    if (!can_be_a_unit(metres))
        throw InputError(fmt::format("{}: a unit of {} m is none of bodies; give m, cm or mm", place, metres));
    return metres;
}

double metres_per_unit(const toml::table &table) {
    const auto *unit = table.get("unit");
    if (!unit)
        return 1.0;
    if (!unit->is_number())
        return metres_per_unit(required_string(table, "unit"), place_of(*unit));
    const double metres = required_number(table, "unit");
    if (!(metres > 0.0))
        throw InputError(fmt::format("{}: the unit is {} m; it has to be positive", place_of(*unit), metres));
    if (!can_be_a_unit(metres))
        throw InputError(
            fmt::format("{}: a unit of {} m is none of bodies; give m, cm or mm", place_of(*unit), metres));
    return metres;
}

} // namespace livermark::support
