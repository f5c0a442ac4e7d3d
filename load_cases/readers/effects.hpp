#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/load_case.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/event_reader.hpp"

namespace livermark::load_cases {

/// Effect of a condition on facets.
struct Effect {
    core::ConditionKind kind;
    std::function<core::Vector3(int facet)> value;
    /// (N) what a prescribed displacement is multiplied by at each node. Empty where it is the same everywhere.
    std::vector<double> node_factor{};
    std::optional<core::RoundLoad> round{}; ///< how a traction is spread, unless it is even
    double press_depth = 0.0;               ///< of a place that presses, whose traction is one newton, see LoadCase
};

/// The keys that say what a condition puts on its place, see load_case_reader.hpp.
std::span<const std::string_view> effect_keys();

/// Keys among them whose values are lengths or vectors, and the place that stands beside them.
const Quantities &effect_quantities();

/// @param table  of the condition; the effect uses the mesh later on
/// @throws support::InputError unless it has one of the keys, with a value that makes sense
Effect read_effect(const toml::table &table, const Selection &selection, const core::TetraMesh &mesh);

/// A place that stands apart from the places above it, with what is put on it.
struct PlacedCondition {
    Selection selection;
    Effect effect;
    double lost_area = 0.0; ///< part of the area of the selection that was given up, 0 to 1/4
};

/// Lets a new place yield to the conditions above it: it gives up the facets that have a condition already, and, where
/// it prescribes a displacement, those with a node to which a condition above prescribes another one. The effect is
/// that on what is left: a disc keeps its resultant.
/// @param table      the [[condition]]
/// @param selection  at least one facet
/// @param above      the load case with the conditions above this one
/// @throws NotOnBody if less than three quarters of the area are left; what read_effect() throws
PlacedCondition place_apart(const toml::table &table, Selection selection, const core::TetraMesh &mesh,
                            const core::LoadCase &above);

} // namespace livermark::load_cases
