#include "fem_reference/mixed_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>

#include "fem_reference/columns.hpp"
#include "fem_reference/saddle_point.hpp"

namespace livermark::fem_reference {

namespace {

/// Columns side by side; lanes that none needs are zero.
std::vector<double> together(std::span<const Conditions> conditions, int lanes,
                             const std::function<double(const Conditions &, std::size_t)> &value) {
    const auto num_rows = conditions.front().load.size();
    std::vector<double> result(lanes * num_rows, 0.0);
    for (std::size_t i = 0; i < num_rows; ++i)
        for (std::size_t c = 0; c < conditions.size(); ++c)
            result[lanes * i + c] = value(conditions[c], i);
    return result;
}

std::vector<double> negative(std::vector<double> values) {
    std::ranges::transform(values, values.begin(), std::negate<>());
    return values;
}

} // namespace

struct MixedSolver::Impl {
    Impl(ChosenSolver &of_k, const PressureSystem &p, double of_residual)
        : solver(of_k), pressure(p), tolerance(of_residual), norm(pressure.norm) {
        const std::vector<double> all_free(static_cast<std::size_t>(pressure.num_pressures()),
                                           std::numeric_limits<double>::quiet_NaN());
        norm.factorise(all_free);
    }

    ChosenSolver &solver;
    const PressureSystem &pressure;
    double tolerance;
    ConstrainedSolver norm; ///< nothing is held
};

MixedSolver::MixedSolver(ChosenSolver &solver, const PressureSystem &pressure, double tolerance)
    : impl_(std::make_unique<Impl>(solver, pressure, tolerance)) {}
MixedSolver::~MixedSolver() = default;
MixedSolver::MixedSolver(MixedSolver &&) noexcept = default;
MixedSolver &MixedSolver::operator=(MixedSolver &&) noexcept = default;

std::size_t MixedSolver::max_columns() const {
    return impl_->solver.max_columns();
}

ConstrainedSolution MixedSolver::solve(std::span<const double> prescribed, std::span<const double> load) {
    return std::move(solve(std::array{Conditions{prescribed, load}}).front());
}

std::vector<ConstrainedSolution> MixedSolver::solve(std::span<const Conditions> conditions) {
    std::vector<std::span<const double>> prescribed;
    for (const auto &column : conditions)
        prescribed.push_back(column.prescribed);
    const auto free = free_unknowns(prescribed);
    std::vector<ConstrainedSolution> solutions(conditions.size());
    auto &inverse = impl_->solver.inverse();
    if (!inverse.set_up(free))
        return solutions;

    const int lanes = free.lanes();
    const auto held = held_entries(free);
    const SaddlePoint matrix{impl_->solver, impl_->pressure, lanes, held};
    const auto load = together(conditions, lanes, [](const auto &column, auto i) { return column.load[i]; });
    auto u = together(conditions, lanes, [](const auto &column, auto i) {
        return std::isnan(column.prescribed[i]) ? 0.0 : column.prescribed[i];
    });
    std::vector<double> p(static_cast<std::size_t>(lanes) * impl_->pressure.num_pressures(), 0.0);
    std::vector<double> residual(u.size()), imbalance(p.size());
    const auto look = [&] {
        matrix.apply(u, p, residual, imbalance);
        for (std::size_t i = 0; i < u.size(); ++i)
            residual[i] -= load[i];
    };
    const auto forces = [&] { // that are not in balance at the free unknowns
        auto of_free = negative(residual);
        zero(held, of_free);
        return of_free;
    };
    const auto sizes = [&] { // of what is not in balance, (lanes)
        const auto of_free = forces();
        auto squares = dots(of_free, of_free, lanes);
        std::ranges::transform(squares, dots(imbalance, imbalance, lanes), squares.begin(), std::plus<>());
        return roots_of(squares);
    };

    look();
    const auto first = sizes();
    const auto first_forces = forces();
    std::vector<double> correction(u.size());
    const auto ending = fem_reference::solve(matrix, inverse, impl_->norm, impl_->tolerance, max_iterations,
                                             first_forces, negative(imbalance), correction, p);
    for (std::size_t i = 0; i < u.size(); ++i)
        u[i] += correction[i];
    look();
    auto left = forces();
    const auto is_balanced =
        impl_->solver.add_solution(left, roots_of(dots(first_forces, first_forces, lanes)), u, held);
    look();

    const auto last = sizes();
    const auto internal_work = dots(u, residual, lanes), external_work = dots(u, load, lanes);
    auto displacements = separated(u, lanes, conditions.size()),
         residuals = separated(residual, lanes, conditions.size());
    for (std::size_t c = 0; c < conditions.size(); ++c)
        solutions[c] = {.unique = true,
                        .displacement = std::move(displacements[c]),
                        .residual = std::move(residuals[c]),
                        .energy = 0.5 * (internal_work[c] + external_work[c]),
                        .converged = ending.converged && is_balanced[c],
                        .iterations = ending.iterations,
                        .relative_residual = first[c] > 0.0 ? last[c] / first[c] : 0.0};
    return solutions;
}

std::string MixedSolver::description(const ConstrainedSolution &solution) const {
    return fmt::format("GMRES, {} iterations, {} and the mass of the pressure", solution.iterations,
                       impl_->solver.inverse().name());
}

} // namespace livermark::fem_reference
