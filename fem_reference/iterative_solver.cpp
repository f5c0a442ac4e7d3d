#include "fem_reference/iterative_solver.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "fem_reference/mass_matrix.hpp"

namespace livermark::fem_reference {

namespace {

/// direction_c = correction_c + beta_c direction_c
void turn(std::span<const double> correction, std::span<const double> beta, std::span<double> direction) {
    scale(beta, direction);
    for (std::size_t i = 0; i < direction.size(); ++i)
        direction[i] += correction[i];
}

} // namespace

IterativeSolver::IterativeSolver(const SymmetricMatrix &stiffness, std::unique_ptr<Preconditioner> preconditioner,
                                 int max_iterations)
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

/// Conjugate gradients (Hestenes and Stiefel 1952), each column on its own but for the matrices that they read
/// together; a column that has converged waits for the others. Each direction is made conjugate to the last one
/// outright, which forgives a preconditioner that is symmetric only to single precision.
IterativeSolver::Ending IterativeSolver::add_solution(std::span<double> residual, std::span<const double> size,
                                                      std::span<double> u, std::span<const std::size_t> held) {
    const int lanes = static_cast<int>(size.size());
    const auto norms = [&] { return roots_of(dots(residual, residual, lanes)); };
    const auto start = norms();
    Ending ending;
    ending.relative_residual.assign(lanes, 0.0);
    std::vector<bool> is_at_work(lanes, true);
    const auto look = [&](const std::vector<double> &norm) {
        for (int c = 0; c < lanes; ++c) {
            const double whole = size[c] > 0.0 ? size[c] : start[c];
            ending.relative_residual[c] = start[c] > 0.0 ? norm[c] / whole : 0.0;
            is_at_work[c] = is_at_work[c] && ending.relative_residual[c] > tolerance;
        }
        return std::ranges::count(is_at_work, true) > 0;
    };

    std::vector<double> direction(u.size(), 0.0), image(u.size(), 0.0), correction(u.size(), 0.0);
    std::vector<double> curvature(lanes, 1.0); // p^T K p
    for (auto norm = start; look(norm) && ending.iterations < max_iterations_; norm = norms()) {
        preconditioner_->apply(residual, correction);
        // The image still holds K times the last direction, to which the new one has to be conjugate.
        auto beta = dots(image, correction, lanes);
        for (int c = 0; c < lanes; ++c)
            beta[c] = is_at_work[c] ? -beta[c] / curvature[c] : 0.0;
        turn(correction, beta, direction);
        multiply(direction, image);
        zero(held, image);
        curvature = dots(direction, image, lanes);
        auto alpha = dots(residual, direction, lanes);
        for (int c = 0; c < lanes; ++c) {
            alpha[c] = is_at_work[c] ? alpha[c] / curvature[c] : 0.0;
            if (is_at_work[c] && (!(curvature[c] > 0.0) || !std::isfinite(alpha[c])))
                return ending; // not positive definite: what there is so far is the answer, and it has not converged
        }
        add_scaled(alpha, direction, u);
        for (double &factor : alpha)
            factor = -factor;
        add_scaled(alpha, image, residual);
        ++ending.iterations;
    }
    return ending;
}

ConstrainedSolution IterativeSolver::solve(std::span<const double> prescribed, std::span<const double> load) {
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
        multiply(u, out);
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = load[i] - out[i];
        return out;
    };
    const auto held = held_entries(free_);
    auto right_hand_side = imbalance();
    zero(held, right_hand_side);
    const auto ending = add_solution(right_hand_side, std::array{0.0}, u, held);
    solution.iterations = ending.iterations;
    solution.relative_residual = ending.relative_residual.front();
    solution.converged = ending.converged(0);
    solution.residual = imbalance();
    for (double &entry : solution.residual)
        entry = -entry;
    solution.energy = 0.5 * (dot(u, solution.residual) + dot(u, load));
    return solution;
}

} // namespace livermark::fem_reference
