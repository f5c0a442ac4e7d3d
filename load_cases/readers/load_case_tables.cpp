#include "load_cases/readers/event_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/places/selector.hpp"

namespace livermark::load_cases {

namespace {

using core::Vector3;

/// Calls a function with every table of a load case that has lengths or directions, and with their keys.
template <class Visit> void for_each_table(toml::table &load_case, const Visit &visit) {
    const auto visit_all = [&](std::string_view key, const Quantities &quantities) {
        auto *node = load_case.get(key);
        if (auto *table = node ? node->as_table() : nullptr)
            visit(*table, quantities);
        else if (auto *list = node ? node->as_array() : nullptr)
            for (auto &entry : *list)
                if (auto *one = entry.as_table())
                    visit(*one, quantities);
    };
    visit(load_case, Quantities{.lengths = {"target_peak_displacement"}, .directions = {"acceleration"}});
    visit_all("condition", effect_quantities());
    for (const auto &event : all_events())
        visit_all(event.name, event.quantities);
}

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
            support::refuse(node,
                            "'{}' has a number of the size {:g}, which is no length, load or time of a body; give one "
                            "from {:g} to {:g} in SI units",
                            key, size, smallest_number, largest_number);
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

void multiply_all(toml::table &table, const std::vector<std::string_view> &keys, double factor) {
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

constexpr std::string_view free_component = "free";

/// Whether a name stands where conditions, balls and probes name patches.
bool names_patch(const toml::node &node, const std::vector<std::string> &patches, bool is_place = false) {
    if (const auto *text = node.as_string())
        return is_place && std::ranges::find(patches, text->get()) != patches.end();
    if (const auto *array = node.as_array())
        return std::ranges::any_of(*array,
                                   [&](const toml::node &item) { return names_patch(item, patches, is_place); });
    if (const auto *table = node.as_table())
        for (const auto &[key, value] : *table)
            if (names_patch(value, patches, key == "patch" || key == "patches" || key == "between"))
                return true;
    return false;
}

/// Vector of three numbers, NaN for what is free; nothing for what their reader refuses.
std::optional<Vector3> vector_in(const toml::array &array) {
    if (array.size() != 3)
        return std::nullopt;
    Vector3 vector;
    for (std::size_t c = 0; c < 3; ++c) {
        const auto &entry = *array.get(c);
        const bool is_free = entry.is_string() && entry.as_string()->get() == free_component;
        const auto number = entry.value<double>();
        if (!is_free && (!number || !std::isfinite(*number)))
            return std::nullopt;
        vector[static_cast<Eigen::Index>(c)] = is_free ? std::numeric_limits<double>::quiet_NaN() : *number;
    }
    return vector;
}

class Directions {
  public:
    explicit Directions(const core::BodyAxes &axes) : axes_(axes) {}

    void turn(toml::table &table, std::string_view key) const {
        auto *array = table.get_as<toml::array>(key);
        const auto vector = array ? vector_in(*array) : std::nullopt;
        if (!vector || vector->isZero(0.0))
            return;
        refuse_doubt(*array);
        const Vector3 turned = vector->array().isNaN().any() ? permuted(*vector, *array) : axes_.from_lps * *vector;
        array->clear();
        for (const double component : turned)
            if (std::isnan(component))
                array->push_back(free_component);
            else
                array->push_back(component + 0.0); // which is no -0
    }

    /// The direction of a disc in the table of a place.
    void turn_disc(toml::table &place) const {
        auto *disc = place.get_as<toml::table>("disc");
        if (!disc || !disc->contains("direction"))
            return;
        turn(*disc, "direction");
        if (disc->contains("point") && !axes_.from_lps.isIdentity(0.0))
            throw NotOnBody(support::place_of(*disc->get("point")),
                            "a place is found by a point of the mesh and a direction of the patient, and this body has "
                            "other axes than the patient",
                            "give a 'region' or a 'patch', or leave the 'direction' out, and the nearest point is "
                            "taken");
    }

  private:
    void refuse_doubt(const toml::node &place) const {
        if (!axes_.doubt.empty())
            throw NotOnBody(support::place_of(place),
                            fmt::format("its directions are those of the patient, and {}", axes_.doubt),
                            "look at the body with `livermark mesh check BODY --picture patches.png`, and write axes = "
                            "\"LPS\", or what is true, into its .toml");
    }

    /// With components that are free, which only stay components where axes become axes.
    Vector3 permuted(const Vector3 &vector, const toml::node &place) const {
        Vector3 turned = Vector3::Zero();
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column) {
                const double entry = axes_.from_lps(row, column);
                if (std::abs(entry) == 1.0)
                    turned[row] = entry * vector[column];
                else if (entry != 0.0)
                    support::refuse(place, "a displacement is free along an axis of the patient, which is none of this "
                                           "mesh; turn the mesh to LPS, or give all three components");
            }
        return turned;
    }

    const core::BodyAxes &axes_;
};

using Missing = std::vector<std::string>;

bool has_one_of(const toml::table &table, auto &&keys) {
    return std::ranges::any_of(keys, [&](std::string_view key) { return table.contains(key); });
}

void look_at_conditions(const toml::table &load_case, Missing &missing) {
    const auto *conditions = load_case["condition"].as_array();
    bool is_constrained = false;
    if (conditions && conditions->is_array_of_tables())
        for (const auto &node : *conditions) {
            const auto &condition = *node.as_table();
            is_constrained = is_constrained || prescribes_displacement(condition);
            if (!has_one_of(condition, keys_with_place()))
                missing.push_back(fmt::format("a place in the [[condition]] of line {} (one of {})",
                                              condition.source().begin.line, fmt::join(keys_with_place(), ", ")));
            if (!has_one_of(condition, effect_keys()))
                missing.push_back(fmt::format("what happens there in the [[condition]] of line {} (one of {})",
                                              condition.source().begin.line, fmt::join(effect_keys(), ", ")));
        }
    if (!is_constrained)
        missing.emplace_back("a [[condition]] that constrains the body (such as patch = \"posterior\" and displacement "
                             "= [0.0, 0.0, 0.0])");
}

void look_at_event(const EventReader &event, const toml::table &load_case, Missing &missing) {
    const auto *table = load_case[event.name].as_table();
    if (!table)
        return;
    for (const auto key : event.required)
        if (!table->contains(key))
            missing.push_back(fmt::format("'{}' in the [{}]", key, event.name));
    if (event.look_for_missing)
        event.look_for_missing(load_case, missing);
}

} // namespace

void bring_to_metres(toml::table &load_case) {
    refuse_beyond_arithmetic(load_case, "load case");
    const double metres = support::metres_per_unit(load_case);
    load_case.erase("unit");
    if (metres != 1.0)
        for_each_table(load_case, [&](toml::table &table, const Quantities &quantities) {
            if (quantities.has_place)
                multiply_place(table, metres);
            multiply_all(table, quantities.lengths, metres);
        });
}

void turn_directions(toml::table &load_case, const core::BodyAxes &axes) {
    if (axes.doubt.empty() && axes.from_lps.isIdentity(0.0))
        return;
    if (!axes.patches.empty() && !names_patch(load_case, axes.patches))
        return;
    const Directions directions(axes);
    for_each_table(load_case, [&](toml::table &table, const Quantities &quantities) {
        for (const auto key : quantities.directions)
            directions.turn(table, key);
        if (quantities.has_place)
            directions.turn_disc(table);
    });
}

void refuse_missing_parts(const toml::table &load_case) {
    Missing missing;
    if (load_case.contains("scale_to_target") && !load_case.contains("target_peak_displacement"))
        missing.emplace_back("'target_peak_displacement' [m], which 'scale_to_target' needs");
    look_at_conditions(load_case, missing);
    for (const auto &event : all_events())
        look_at_event(event, load_case, missing);
    if (missing.size() > 1)
        support::refuse(load_case, "{} things are missing: {}; add them", missing.size(), fmt::join(missing, "; "));
}

} // namespace livermark::load_cases
