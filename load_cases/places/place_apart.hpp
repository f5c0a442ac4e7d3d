#pragma once

#include "core/load_case.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/effects.hpp"
#include "support/toml_input.hpp"

namespace livermark::load_cases {

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
