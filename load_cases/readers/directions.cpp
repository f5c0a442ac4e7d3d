#include "load_cases/readers/directions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string_view>

#include "load_cases/places/selector.hpp"
#include "load_cases/readers/effects.hpp"

namespace livermark::load_cases {

namespace {

using core::Vector3;

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

/// Three numbers, NaN for what is free; nothing for what their reader refuses.
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

    /// That of a disc in the table of a place.
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
                    throw support::InputError(
                        fmt::format("{}: a displacement is free along an axis of the patient, which is none of this "
                                    "mesh; turn the mesh to LPS, or give all three components",
                                    support::place_of(place)));
            }
        return turned;
    }

    const core::BodyAxes &axes_;
};

} // namespace

void turn_directions(toml::table &load_case, const core::BodyAxes &axes) {
    if (axes.doubt.empty() && axes.from_lps.isIdentity(0.0))
        return;
    if (!axes.patches.empty() && !names_patch(load_case, axes.patches))
        return;
    const Directions directions(axes);
    directions.turn(load_case, "acceleration");
    if (auto *conditions = load_case.get_as<toml::array>("condition"))
        for (auto &node : *conditions)
            if (auto *condition = node.as_table()) {
                for (const auto key : vector_effect_keys())
                    directions.turn(*condition, key);
                directions.turn_disc(*condition);
            }
    for (const std::string_view key : {"tool", "touch"})
        if (auto *table = load_case.get_as<toml::table>(key)) {
            directions.turn(*table, "slide");
            directions.turn_disc(*table);
        }
}

} // namespace livermark::load_cases
