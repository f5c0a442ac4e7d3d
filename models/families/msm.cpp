#include <chrono>
#include <cmath>

#include "models/model_table.hpp"
#include "msm/equilibrium.hpp"
#include "msm/spectrum.hpp"
#include "msm/spring_law.hpp"
#include "msm/spring_network.hpp"

namespace livermark::models::families {

namespace {

using Clock = std::chrono::steady_clock;

double seconds(Clock::duration duration) {
    return std::chrono::duration<double>(duration).count();
}

/// |u - u_lin| / |u|
double nonlinearity(const msm::Equilibrium &equilibrium) {
    double difference = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < equilibrium.displacement.size(); ++i) {
        difference += (equilibrium.displacement[i] - equilibrium.linear_displacement[i]).squaredNorm();
        size += equilibrium.displacement[i].squaredNorm();
    }
    return std::sqrt(difference / size);
}

core::Solution solve(const core::Problem &problem, const msm::SpringLaw &law) {
    const auto start = Clock::now();
    auto springs = msm::spring_network(*problem.body, law);
    const auto ready = Clock::now();
    const auto &points = problem.body->mesh.points;
    const auto conditions = msm::nodal_conditions(problem, springs.node_mass);
    auto equilibrium = msm::find_equilibrium(springs, points, conditions);

    core::Solution solution;
    solution.status = equilibrium.status;
    solution.message = equilibrium.message;
    solution.reaction = msm::constraint_forces(problem, conditions, equilibrium.constraint_force);
    solution.nonlinearity = nonlinearity(equilibrium);
    solution.degrees_of_freedom = static_cast<std::int64_t>(3 * points.size());
    solution.setup_seconds = seconds(ready - start);
    solution.solve_seconds = seconds(Clock::now() - ready);
    auto positions = points;
    for (std::size_t i = 0; i < positions.size(); ++i)
        positions[i] += equilibrium.displacement[i];
    solution.strain_energy = msm::elastic_energy(springs, positions);
    solution.displacement = std::move(equilibrium.displacement);
    solution.springs = std::move(springs);
    return solution;
}

} // namespace

/// A mass-spring model per spring law, under the law's name: barycentric masses, springs on the edges of the mesh.
ModelFamily msm() {
    return {.name = {}, .models = [](const ModelOptions &) {
                std::vector<core::Model> models;
                for (const auto &law : livermark::msm::all_spring_laws())
                    models.push_back(
                        {.name = law.name,
                         .summary = law.summary,
                         .source = law.source,
                         .solve = [law](const core::Problem &problem) { return solve(problem, law); },
                         .modes = [law](const core::Problem &problem,
                                        int count) { return livermark::msm::lowest_modes(problem, law, count); }});
                return models;
            }};
}

} // namespace livermark::models::families
