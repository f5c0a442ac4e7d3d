#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "results/records/sensitivity.hpp"
#include "studies/progress.hpp"
#include "studies/sensitivity/outputs.hpp"

namespace livermark::studies {

struct BudgetOptions {
    std::vector<std::string> compared;        ///< models, by name
    bool reference_on_mesh = false;           ///< the error bar of the mesh is unknown then
    bool without_law = false;                 ///< the law is unknown then
    std::optional<double> displacement_noise; ///< [m]
};

/// A budget, and what the reference answers.
struct Budget {
    results::ErrorBudget budget;
    OutputValues reference;
};

/// How many steps budget_of() takes.
int num_budget_steps(const BudgetOptions &options);

/// What outputs are uncertain by from all but the patient; the bar of displacements is that of the relative L2 norm.
/// The law is that of large_<load case>, where the body has room for it: fem_p2p1_ogden over fem_p2p1_neo_hookean at
/// the whole load.
/// @param body_name  as the user named it
/// @param nominal    body and load case as their files have them, with loads scaled
/// @throws support::InputError for a model that is not known
Budget budget_of(const std::string &body_name, const core::Problem &nominal, const std::vector<Output> &outputs,
                 const BudgetOptions &options, Steps &steps);

} // namespace livermark::studies
