#pragma once

#include <vector>

#include "core/load_case.hpp"
#include "core/solution.hpp"
#include "msm/motion.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

/// Point masses and springs under dead loads, with unknown 3 i + component for node i:
/// M u'' = f - grad U(x + u) - alpha M v - beta sum over springs of k (n . (v_a - v_b)) n,
/// n the direction of the spring now. The last term, axial dashpots of beta k, is beta K v at rest (Rayleigh damping)
/// and leaves rigid motion alone. Prescribed components stay where the motion starts. The slow, obvious kernel.
/// @param springs     kept alive and unchanged by the caller, as are positions and conditions
/// @param positions   shape (N) [m], where the springs are at rest
/// @param conditions  loads, and which components are held
/// @return of 3N unknowns
EquationOfMotion spring_motion(const core::SpringNetwork &springs, const std::vector<core::Vector3> &positions,
                               const NodalConditions &conditions, const core::RayleighDamping &damping);

/// 1/2 v^T M v [J]
double kinetic_energy(const EquationOfMotion &equation, const State &state);

/// A nodal field as unknowns, and back.
Eigen::VectorXd to_unknowns(const std::vector<core::Vector3> &field);
std::vector<core::Vector3> to_field(const Eigen::VectorXd &unknowns);

} // namespace livermark::msm
