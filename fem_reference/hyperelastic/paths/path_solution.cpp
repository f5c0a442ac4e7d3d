#include "fem_reference/hyperelastic/paths/path_solution.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>
#include <utility>

namespace livermark::hyperelastic {

namespace {

using core::Vector3;

/// |u - v| / |u| with the norm of core::Comparison.
double relative_difference(const core::TetraMesh &mesh, const std::vector<Vector3> &u, const std::vector<Vector3> &v) {
    const auto volumes = core::nodal_volumes(mesh);
    double difference = 0.0, size = 0.0;
    for (std::size_t node = 0; node < u.size(); ++node) {
        difference += volumes[node] * (u[node] - v[node]).squaredNorm();
        size += volumes[node] * u[node].squaredNorm();
    }
    return std::sqrt(difference / size);
}

} // namespace

void check(const LoadPath &path) {
    const auto &fractions = path.fractions;
    const bool ascends = std::ranges::adjacent_find(fractions, std::greater_equal<>()) == fractions.end();
    if (fractions.empty() || !ascends || !(fractions.front() > 0.0) || fractions.back() != 1.0)
        throw std::invalid_argument("the fractions of a load path have to ascend from above 0 to 1");
}

std::string description(const FollowedPath &path, const std::string &inverses) {
    std::size_t corrections = 0, linear = 0, most = 0;
    for (const auto &step : path.steps) {
        corrections += step.linear_iterations.size();
        most = std::max(most, step.linear_iterations.size());
        for (const int iterations : step.linear_iterations)
            linear += static_cast<std::size_t>(iterations);
    }
    return fmt::format("Newton, {} load steps, {} linear solves, {} in a step at most; GMRES, {} iterations, {} {}",
                       path.steps.size(), corrections, most, linear, path.factorisations, inverses);
}

FollowedPath free_to_move() {
    return {.status = core::SolutionStatus::not_converged,
            .message = "the prescribed displacements leave the body, or a part of it, free to move as a rigid body; "
                       "constrain it in all six ways"};
}

PathSolution path_solution(const FollowedPath &followed, const core::TetraMesh &mesh, const core::LoadCase &load_case,
                           const std::function<std::vector<Vector3>(const std::vector<double> &)> &at_mesh_nodes) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto resultants = core::press_resultants(load_case, mesh);
    PathSolution result;
    for (const auto &point : followed.points) {
        auto reaction = point.reaction;
        for (std::size_t place = 0; place < reaction.size(); ++place)
            reaction[place] += point.press * resultants[place];
        result.points.push_back({.fraction = point.fraction,
                                 .displacement = at_mesh_nodes(point.state.displacement),
                                 .reaction = std::move(reaction),
                                 .strain_energy = point.strain_energy,
                                 .smallest_jacobian = point.smallest_jacobian});
    }
    result.steps = followed.steps;
    auto &solution = result.solution;
    solution.status = followed.status;
    solution.message = followed.message;
    solution.setup_seconds = followed.setup_seconds;
    solution.solve_seconds = followed.solve_seconds;
    if (result.points.empty()) {
        solution.displacement.assign(mesh.points.size(), Vector3::Constant(nan));
        solution.reaction.assign(resultants.size(), Vector3::Constant(nan));
        solution.strain_energy = nan;
        return result;
    }
    const auto &end = result.points.back();
    solution.displacement = end.displacement;
    solution.reaction = end.reaction;
    solution.strain_energy = end.strain_energy;
    if (solution.status == core::SolutionStatus::ok)
        solution.nonlinearity = relative_difference(mesh, end.displacement, at_mesh_nodes(followed.linearised));
    return result;
}

} // namespace livermark::hyperelastic
