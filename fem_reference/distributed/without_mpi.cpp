#include <stdexcept>

#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"

/// A build without MPI has one rank, on which nobody asks for these.
namespace livermark {

core::Solution fem_reference::solve_distributed(const core::Problem &, const DistributedOptions &) {
    throw std::logic_error("there is one rank");
}

hyperelastic::PathSolution hyperelastic::solve_distributed(const core::Problem &, const MaterialLaw &, const LoadPath &,
                                                           std::span<const double>) {
    throw std::logic_error("there is one rank");
}

} // namespace livermark
