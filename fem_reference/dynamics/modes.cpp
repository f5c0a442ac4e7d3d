#include "fem_reference/dynamics/modes.hpp"

#include <chrono>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/dynamics/eigenpairs.hpp"
#include "fem_reference/dynamics/mass_matrix.hpp"
#include "fem_reference/facet_conditions.hpp"

namespace livermark::fem_reference {

core::Modes lowest_modes(const core::Problem &problem, int degree, int count) {
    const auto start = std::chrono::steady_clock::now();
    const auto &mesh = problem.body->mesh;
    check_facets(problem.load_case, mesh);
    const auto system = assemble(*problem.body, degree);
    const auto mass = consistent_mass(*problem.body, system);
    const auto conditions = dof_conditions(problem.load_case, system);
    auto pairs = lowest_eigenpairs(compressed_rows(system.stiffness), mass, conditions.prescribed, count);

    core::Modes modes;
    modes.angular_frequency = std::move(pairs.angular_frequency);
    modes.shape.reserve(pairs.shape.size() * mesh.points.size());
    for (const auto &shape : pairs.shape)
        for (int node = 0; node < mesh.num_nodes(); ++node)
            modes.shape.emplace_back(core::Vector3::Map(&shape[3 * node]));
    modes.degrees_of_freedom = static_cast<std::int64_t>(conditions.prescribed.size());
    modes.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return modes;
}

} // namespace livermark::fem_reference
