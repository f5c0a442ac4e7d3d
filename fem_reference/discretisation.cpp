#include "fem_reference/discretisation.hpp"

#include <stdexcept>
#include <string>

#include "fem_reference/deal_ii_mesh.hpp"

namespace livermark::fem_reference {

Discretisation::Discretisation(const core::Body &body, int degree, Formulation formulation) {
    if (formulation == Formulation::displacement) {
        system = assemble(body, degree);
        return;
    }
    if (degree != 2)
        throw std::invalid_argument("the mixed formulation takes quadratic elements, not those of degree " +
                                    std::to_string(degree));
    const auto order = has_pressure(body) ? NodeOrder::by_distance : NodeOrder::of_mesh;
    const DealIiMesh mesh(body.mesh);
    system = assemble(without_pressure(body), mesh, degree, order);
    pressure = assemble_pressure(body, mesh, system);
}

Corners::Corners(const core::Body &body, SolverChoice choice, const Discretisation &matrices, int largest_factor) {
    const bool is_mixed = matrices.pressure.num_pressures() > 0;
    const bool is_large =
        matrices.system.nodes_per_cell > 4 && matrices.system.stiffness.num_rows() > largest_direct_quadratic_system;
    if (choice != SolverChoice::automatic || !(is_mixed || is_large))
        return;
    system = std::make_unique<ElasticSystem>(assemble(is_mixed ? without_pressure(body) : body, 1));
    const bool is_factored = system->stiffness.num_rows() <= largest_factor;
    solver = std::make_unique<ChosenSolver>(*system, is_factored ? SolverChoice::direct : SolverChoice::iterative);
}

} // namespace livermark::fem_reference
