#include "meshes/io/material_reader.hpp"

#include <fmt/format.h>

#include "core/mesh/plausible_liver.hpp"
#include "support/input_error.hpp"

namespace livermark::meshes {

namespace {

/// Beyond them nothing is known, and squares of frequencies leave double precision.
constexpr double heaviest = 1e5;  // [kg/m^3] metals have 2e4
constexpr double stiffest = 1e13; // [Pa] diamond has 1e12
constexpr double lightest = 1e-6, softest = 1e-6;

} // namespace

void check_material(const core::Material &material, const std::string &place) {
    if (!(material.density > 0.0))
        throw support::InputError(
            fmt::format("{}: the density is {} kg/m^3; it has to be positive", place, material.density));
    if (!(material.young_modulus > 0.0))
        throw support::InputError(
            fmt::format("{}: Young's modulus is {} Pa; it has to be positive", place, material.young_modulus));
    if (!(material.density >= lightest && material.density <= heaviest))
        throw support::InputError(
            fmt::format("{}: the density is {:g} kg/m^3, which no matter has; give one from {:g} to "
                        "{:g} kg/m^3",
                        place, material.density, lightest, heaviest));
    if (!(material.young_modulus >= softest && material.young_modulus <= stiffest))
        throw support::InputError(
            fmt::format("{}: Young's modulus is {:g} Pa, which no matter has; give one from {:g} to "
                        "{:g} Pa",
                        place, material.young_modulus, softest, stiffest));
    if (!(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5))
        throw support::InputError(
            fmt::format("{}: Poisson's ratio is {}; it has to lie between -1 and 0.5, both excluded", place,
                        material.poisson_ratio));
    if (material.poisson_ratio > core::largest_poisson_ratio)
        throw support::InputError(
            fmt::format("{}: Poisson's ratio is {:.12g}, so close to 0.5 that its equations have no "
                        "solution in double precision; take {} at most",
                        place, material.poisson_ratio, core::largest_poisson_ratio));
}

void refuse_unknown_material_keys(const toml::table &table) {
    support::refuse_unknown_keys(table, {"density", "young_modulus", "poisson_ratio", "source"});
}

core::Material read_material(const toml::table &table) {
    refuse_unknown_material_keys(table);
    if (table.contains("source"))
        support::required_string(table, "source");
    const core::Material material{.density = support::required_number(table, "density"),
                                  .young_modulus = support::required_number(table, "young_modulus"),
                                  .poisson_ratio = support::required_number(table, "poisson_ratio")};
    check_material(material, support::place_of(table));
    return material;
}

} // namespace livermark::meshes
