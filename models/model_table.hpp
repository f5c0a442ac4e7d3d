#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/model.hpp"
#include "fem_reference/solver_choice.hpp"

namespace livermark::models {

/// The model that all others are compared with, the same on the refined mesh, which takes its place where it is not
/// good enough, and the one that a mass-spring model has to beat.
inline constexpr std::string_view reference_model = "fem_p2";
inline constexpr std::string_view refined_reference_model = "fem_p2_refined";
inline constexpr std::string_view baseline_model = "fem_p1";

/// What a user may choose about models.
struct ModelOptions {
    fem_reference::SolverChoice fem_solver = fem_reference::SolverChoice::automatic;
};

/// Models that come from one adapter. One file each in families/, named as the family.
struct ModelFamily {
    std::string name;                                         ///< the file stem; set by the table
    std::vector<core::Model> (*models)(const ModelOptions &); ///< at least one
};

/// Every family of families/, in alphabetical order.
std::span<const ModelFamily> all_families();

/// Every model of every family. Models of one call may share what they keep from one problem to the next, so they are
/// for one thread.
std::vector<core::Model> all_models(const ModelOptions &options = {});

} // namespace livermark::models
