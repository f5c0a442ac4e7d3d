#include "fem_reference/solvers/iterative_solver.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numeric>

#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/solvers/matrices.hpp"

namespace livermark::fem_reference {

IterativeSolver::IterativeSolver(const SymmetricBlocks<double> &stiffness,
                                 std::unique_ptr<Preconditioner> preconditioner, int max_iterations)
    : stiffness_(stiffness), preconditioner_(std::move(preconditioner)), max_iterations_(max_iterations) {}

bool IterativeSolver::set_up(std::span<const double> prescribed) {
    const auto start = std::chrono::steady_clock::now();
    auto wanted = free_unknowns(std::array{prescribed});
    const bool is_new = wanted != free_;
    free_ = {}; // what follows may throw
    // The preconditioner knows best whether it is still what it was: it may share parts with another one.
    const bool unique = preconditioner_->set_up(wanted);
    free_ = std::move(wanted);
    if (is_new)
        setup_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return unique;
}

/// Conjugate gradients (Hestenes and Stiefel 1952). Each direction is made conjugate to the last one outright, which
/// forgives a preconditioner that is symmetric only to single precision.
IterativeSolver::Ending IterativeSolver::add_solution(std::span<double> residual, std::span<double> u,
                                                      std::span<const std::size_t> constrained, double size,
                                                      double goal) {
    Ending ending{.relative_residual = size > 0.0 ? std::sqrt(dot(residual, residual)) / size : 0.0};
    std::vector<double> direction(u.size(), 0.0), image(u.size(), 0.0);
    std::vector<float> of_one(u.size()), correction(u.size()); // the residual over its size
    double curvature = 1.0;                                    // p^T K p
    while (ending.relative_residual > goal && ending.iterations < max_iterations_) {
        const double left = ending.relative_residual * size;
        for (std::size_t i = 0; i < u.size(); ++i)
            of_one[i] = static_cast<float>(residual[i] / left);
        preconditioner_->apply(of_one, correction);
        // The image still holds K times the last direction, to which the new one has to be conjugate.
        const double beta = -std::inner_product(image.begin(), image.end(), correction.begin(), 0.0) / curvature;
        for (std::size_t i = 0; i < u.size(); ++i)
            direction[i] = correction[i] + beta * direction[i];
        stiffness_.multiply(direction, image);
        zero(constrained, image);
        curvature = dot(direction, image);
        const double alpha = dot(residual, direction) / curvature;
        if (!(curvature > 0.0) || !std::isfinite(alpha))
            break; // not positive definite: what there is so far is the solution, and it has not converged
        for (std::size_t i = 0; i < u.size(); ++i) {
            u[i] += alpha * direction[i];
            residual[i] -= alpha * image[i];
        }
        ending.relative_residual = std::sqrt(dot(residual, residual)) / size;
        ++ending.iterations;
    }
    return ending;
}

ConstrainedSolution IterativeSolver::solve(std::span<const double> prescribed, std::span<const double> load,
                                           const Aim &aim) {
    ConstrainedSolution solution;
    solution.unique = set_up(prescribed);
    if (!solution.unique)
        return solution;
    auto &u = solution.displacement;
    u.resize(prescribed.size());
    for (std::size_t i = 0; i < u.size(); ++i)
        u[i] = std::isnan(prescribed[i]) ? 0.0 : prescribed[i];
    const auto imbalance = [&] { // f - K u
        std::vector<double> out(u.size());
        stiffness_.multiply(u, out);
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = load[i] - out[i];
        return out;
    };
    const auto constrained = constrained_entries(free_);
    auto right_hand_side = imbalance();
    zero(constrained, right_hand_side);
    const double size = std::sqrt(dot(right_hand_side, right_hand_side));
    if (!aim.guess.empty() && size > 0.0) { // without a load the solution is what is prescribed
        for (std::size_t i = 0; i < u.size(); ++i)
            if (std::isnan(prescribed[i]))
                u[i] = aim.guess[i];
        right_hand_side = imbalance();
        zero(constrained, right_hand_side);
    }
    const auto ending = add_solution(right_hand_side, u, constrained, size, aim.relative_residual);
    solution.iterations = ending.iterations;
    solution.relative_residual = ending.relative_residual;
    solution.converged = ending.relative_residual <= aim.relative_residual;
    solution.residual = imbalance();
    for (double &entry : solution.residual)
        entry = -entry;
    solution.energy = 0.5 * (dot(u, solution.residual) + dot(u, load));
    return solution;
}

namespace {

constexpr int num_corners = 4;

/// The corners of the fine mesh are the corners of the coarse one, where pressures are the same, and the midpoints of
/// its edges, where they are the mean of both ends.
SparseRows pressure_prolongation(const ElasticSystem &coarse, const PressureSystem &coarse_pressure,
                                 const ElasticSystem &fine, const PressureSystem &fine_pressure,
                                 const Prolongation &displacement, std::span<const int> parent) {
    std::vector<int> coarse_node(fine.points.size(), -1);
    for (std::size_t node = 0; node < displacement.fine_node.size(); ++node)
        coarse_node[displacement.fine_node[node]] = static_cast<int>(node);
    std::vector<std::vector<int>> ends(fine_pressure.num_pressures()); // one or two pressures
    for (std::size_t child = 0; child < fine_pressure.of_cell.size(); ++child) {
        const auto t = static_cast<std::size_t>(parent[child]);
        const auto &pressures = coarse_pressure.of_cell[t];
        if (pressures.front() < 0)
            continue;
        const auto nodes = std::span(coarse.cell_nodes).subspan(t * coarse.nodes_per_cell, coarse.nodes_per_cell);
        for (int corner = 0; corner < num_corners; ++corner) {
            auto &of_corner = ends[fine_pressure.of_cell[child][corner]];
            if (!of_corner.empty())
                continue;
            const int node = coarse_node[fine.cell_nodes[child * fine.nodes_per_cell + corner]];
            const auto local = static_cast<int>(std::ranges::find(nodes, node) - nodes.begin());
            if (local < num_corners) {
                of_corner = {pressures[local]};
            } else {
                const auto [a, b] = edges_of_quadratic[local - num_corners];
                of_corner = {pressures[a], pressures[b]};
            }
        }
    }
    SparseRows result;
    result.row_start.push_back(0);
    for (const auto &of_corner : ends) {
        for (const int pressure : of_corner) {
            result.column.push_back(pressure);
            result.value.push_back(1.0 / static_cast<double>(of_corner.size()));
        }
        result.row_start.push_back(static_cast<int>(result.column.size()));
    }
    return result;
}

} // namespace

std::vector<double> NestedIteration::prolonged_pressure(std::span<const double> coarse, int lanes) const {
    const std::size_t num_rows = pressure.row_start.size() - 1;
    std::vector<double> fine(lanes * num_rows, 0.0);
    for (std::size_t row = 0; row < num_rows; ++row)
        for (int k = pressure.row_start[row]; k < pressure.row_start[row + 1]; ++k)
            for (int c = 0; c < lanes; ++c)
                fine[lanes * row + c] +=
                    pressure.value[k] * coarse[static_cast<std::size_t>(lanes) * pressure.column[k] + c];
    return fine;
}

NestedIteration nested_iteration(const ElasticSystem &coarse, const PressureSystem &coarse_pressure,
                                 const ElasticSystem &fine, const PressureSystem &fine_pressure,
                                 std::span<const int> parent) {
    auto displacement = prolongation(coarse, fine, parent);
    const auto by_number = parent.empty() ? parents_by_number(coarse, fine) : std::vector<int>{};
    auto pressure = pressure_prolongation(coarse, coarse_pressure, fine, fine_pressure, displacement,
                                          parent.empty() ? by_number : parent);
    return {std::move(displacement), std::move(pressure)};
}

} // namespace livermark::fem_reference
