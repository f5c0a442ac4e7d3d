#include "fem_reference/iterative_solver.hpp"

#include <chrono>
#include <cmath>

#include "fem_reference/mass_matrix.hpp"

namespace livermark::fem_reference {

namespace {

void keep_free(const std::vector<bool> &is_free, std::span<double> vector) {
    for (std::size_t i = 0; i < vector.size(); ++i)
        if (!is_free[i])
            vector[i] = 0.0;
}

/// How conjugate gradients ended.
struct Ending {
    int iterations = 0;
    double relative_residual = 0.0;
};

/// Conjugate gradients for the free rows (Hestenes and Stiefel 1952). Each direction is made conjugate to the last one
/// outright, which forgives a preconditioner that is symmetric only to single precision.
/// @param residual  shape (n), the right-hand side, zero where not free; used up
/// @param size      what the residual is relative to; its own norm where it is 0
/// @param u         shape (n), the solution is added to its free entries
Ending conjugate_gradients(const SymmetricBlocks &matrix, const std::vector<bool> &is_free,
                           Preconditioner &preconditioner, int max_iterations, std::vector<double> residual,
                           double size, std::vector<double> &u) {
    const double start = std::sqrt(dot(residual, residual));
    Ending ending;
    if (start == 0.0)
        return ending;
    const double whole = size > 0.0 ? size : start;
    std::vector<double> direction(u.size(), 0.0), image(u.size(), 0.0), correction(u.size(), 0.0);
    double curvature = 1.0; // p^T K p
    ending.relative_residual = start / whole;
    while (ending.relative_residual > IterativeSolver::tolerance && ending.iterations < max_iterations) {
        preconditioner.apply(residual, correction);
        // The image still holds K times the last direction, to which the new one has to be conjugate.
        const double beta = -dot(image, correction) / curvature;
        for (std::size_t i = 0; i < u.size(); ++i)
            direction[i] = correction[i] + beta * direction[i];
        matrix.multiply(direction, image);
        keep_free(is_free, image);
        curvature = dot(direction, image);
        const double alpha = dot(residual, direction) / curvature;
        if (!(curvature > 0.0) || !std::isfinite(alpha))
            break; // not positive definite: what there is so far is the answer, and it has not converged
        for (std::size_t i = 0; i < u.size(); ++i) {
            u[i] += alpha * direction[i];
            residual[i] -= alpha * image[i];
        }
        ++ending.iterations;
        ending.relative_residual = std::sqrt(dot(residual, residual)) / whole;
    }
    return ending;
}

} // namespace

IterativeSolver::IterativeSolver(const SymmetricMatrix &stiffness, std::unique_ptr<Preconditioner> preconditioner,
                                 int max_iterations)
    : stiffness_(stiffness), preconditioner_(std::move(preconditioner)), max_iterations_(max_iterations) {}

bool IterativeSolver::set_up(std::span<const double> prescribed) {
    const auto start = std::chrono::steady_clock::now();
    std::vector<bool> wanted(prescribed.size());
    for (std::size_t i = 0; i < prescribed.size(); ++i)
        wanted[i] = std::isnan(prescribed[i]);
    const bool is_new = wanted != is_free_;
    is_free_.clear(); // what follows may throw
    // The preconditioner knows best whether it is still what it was: it may share parts with another one.
    const bool unique = preconditioner_->set_up(wanted);
    is_free_ = std::move(wanted);
    if (is_new)
        setup_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return unique;
}

ConstrainedSolution IterativeSolver::solve(std::span<const double> prescribed, std::span<const double> load,
                                           double size) {
    ConstrainedSolution solution;
    solution.unique = set_up(prescribed);
    if (!solution.unique)
        return solution;
    auto &u = solution.displacement;
    u.resize(prescribed.size());
    for (std::size_t i = 0; i < u.size(); ++i)
        u[i] = is_free_[i] ? 0.0 : prescribed[i];
    const auto imbalance = [&] { // f - K u
        std::vector<double> out(u.size());
        multiply(u, out);
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = load[i] - out[i];
        return out;
    };
    auto right_hand_side = imbalance();
    keep_free(is_free_, right_hand_side);
    const auto ending = conjugate_gradients(stiffness_, is_free_, *preconditioner_, max_iterations_,
                                            std::move(right_hand_side), size, u);
    solution.iterations = ending.iterations;
    solution.relative_residual = ending.relative_residual;
    solution.converged = ending.relative_residual <= tolerance;
    solution.residual = imbalance();
    for (double &entry : solution.residual)
        entry = -entry;
    solution.energy = 0.5 * (dot(u, solution.residual) + dot(u, load));
    return solution;
}

} // namespace livermark::fem_reference
