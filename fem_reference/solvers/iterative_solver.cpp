#include "fem_reference/solvers/iterative_solver.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <numeric>

#include "fem_reference/dynamics/mass_matrix.hpp"

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

} // namespace livermark::fem_reference
