#pragma once

#include <memory>

#include "core/problem.hpp"
#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/formulation.hpp"
#include "fem_reference/linear/pressure_system.hpp"

namespace livermark::fem_reference {

/// The matrices of one body.
struct Discretisation {
    /// @throws std::invalid_argument for the mixed formulation of linear elements, or as assemble() does
    Discretisation(const core::Body &body, int degree, Formulation formulation);

    ElasticSystem system;
    PressureSystem pressure; ///< empty where nothing is nearly incompressible
};

/// Linear elements on the same body, whose solver is the coarse one of iterations on quadratic elements: of the mixed
/// formulation, which needs only an approximate inverse of K, and of large bodies in displacements alone. The factor of
/// quadratic elements fills most of the memory and takes most of the time, and so would that of the linear ones of a
/// very large body, which multigrid solves. Empty where the user chose a solver.
struct Corners {
    Corners() = default;
    /// @param largest_factor  unknowns of linear elements beyond which there is multigrid
    Corners(const core::Body &body, SolverChoice choice, const Discretisation &matrices,
            int largest_factor = largest_direct_coarse_system);

    std::unique_ptr<ElasticSystem> system;
    std::unique_ptr<ChosenSolver> solver;
};

} // namespace livermark::fem_reference
