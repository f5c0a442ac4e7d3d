#pragma once

#include <span>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"

namespace livermark::hyperelastic {

/// Hyperelasticity whose isochoric stress relaxes by one Prony series in all regions, quasi-static, along a slow
/// history: at each point of integration the branches follow isochoric_stress() by the exponential update of
/// core::BranchStep, and each step has a potential (IsochoricPart), whose equilibrium Newton's method finds as on a
/// path of loads. Steps are those of the history, and their halves where it finds none. The error is of second order
/// in the steps.
/// @param problem            with a slow history; a release is not looked at
/// @param tolerance          as LoadPath::tolerance
/// @param follower_pressure  as of solve()
/// @return a core::PathPoint for each time; the other fields are those of SlowHistory::whole_load_record().
///   strain_energy is that of the elastic law after all time, and of the branches as if their strains were small,
///   and dissipated_energy what these branches lose. Status not_converged if the way ended early.
/// @throws as solve()
core::Solution solve_history(const core::Problem &problem, const MaterialLaw &law, const Discretisation &discretisation,
                             double tolerance, std::span<const double> follower_pressure = {});

} // namespace livermark::hyperelastic
