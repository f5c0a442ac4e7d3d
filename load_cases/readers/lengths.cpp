#include "load_cases/readers/lengths.hpp"

#include <cmath>
#include <fmt/format.h>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "support/input_error.hpp"
#include "support/length_unit.hpp"

namespace livermark::load_cases {

namespace {

using Keys = std::initializer_list<std::string_view>;

/// Sizes beyond which squares of displacements and energies leave double precision, or are nobody's load.
constexpr double largest_number = 1e12, smallest_number = 1e-100;

void refuse_beyond_arithmetic(const toml::node &node, std::string_view key) {
    if (const auto *table = node.as_table()) {
        for (const auto &[name, value] : *table)
            refuse_beyond_arithmetic(value, name.str());
    } else if (const auto *array = node.as_array()) {
        for (const auto &entry : *array)
            refuse_beyond_arithmetic(entry, key);
    } else if (node.is_number()) {
        const double size = std::abs(node.value<double>().value_or(0.0));
        if (std::isfinite(size) && (size > largest_number || (size > 0.0 && size < smallest_number)))
            throw support::InputError(
                fmt::format("{}: '{}' has a number of the size {:g}, which is no length, load or time of a body; give "
                            "one from {:g} to {:g} in SI units",
                            support::place_of(node), key, size, smallest_number, largest_number));
    }
}

/// A number of the parser's, which knows its line.
void put_number(toml::table &table, std::string_view key, double value) {
    const auto &source = table.get(key)->source();
    auto again = toml::parse(std::string(source.begin.line > 0 ? source.begin.line - 1 : 0, '\n') +
                                 fmt::format("x = {:.17e}", value),
                             source.path ? *source.path : std::string());
    table.insert_or_assign(key, std::move(*again.get("x")->as_floating_point()));
}

/// Product in place; an entry that is no number stays, for its reader to read or refuse.
void multiply(toml::table &table, std::string_view key, double factor) {
    auto *node = table.get(key);
    if (!node)
        return;
    if (auto *array = node->as_array()) {
        for (std::size_t i = 0; i < array->size(); ++i)
            if (const auto &entry = *array->get(i); entry.is_number())
                array->replace(array->cbegin() + static_cast<std::ptrdiff_t>(i), factor * *entry.value<double>());
    } else if (node->is_number()) {
        put_number(table, key, factor * *node->value<double>());
    }
}

void multiply_all(toml::table &table, Keys keys, double factor) {
    for (const auto key : keys)
        multiply(table, key, factor);
}

/// Lengths of a place, in the table that has it.
void multiply_place(toml::table &table, double factor) {
    if (auto *disc = table["disc"].as_table())
        multiply_all(*disc, {"point", "radius"}, factor);
    if (auto *edge = table["edge"].as_table())
        multiply_all(*edge, {"width", "length"}, factor);
}

/// @param name  of a list of tables
template <class Visit> void for_each_table(toml::table &load_case, std::string_view name, const Visit &visit) {
    if (auto *list = load_case[name].as_array())
        for (auto &node : *list)
            if (auto *table = node.as_table())
                visit(*table);
}

} // namespace

void bring_to_metres(toml::table &load_case) {
    refuse_beyond_arithmetic(load_case, "load case");
    const double metres = support::metres_per_unit(load_case);
    load_case.erase("unit");
    if (metres == 1.0)
        return;
    multiply(load_case, "target_peak_displacement", metres);
    for_each_table(load_case, "condition", [&](toml::table &condition) {
        multiply_place(condition, metres);
        multiply_all(condition, {"displacement", "push", "press", "press_along"}, metres);
    });
    if (auto *touch = load_case["touch"].as_table()) {
        multiply_place(*touch, metres);
        multiply_all(*touch, {"radius", "depth", "slide"}, metres);
    }
    if (auto *tool = load_case["tool"].as_table())
        multiply_all(*tool, {"radius", "slide"}, metres);
    for_each_table(load_case, "needle", [&](toml::table &needle) {
        multiply_all(needle, {"entry", "target", "depth", "diameter", "spread", "step"}, metres);
    });
}

} // namespace livermark::load_cases
