#include "fem_reference/linear/mixed_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <optional>

#include "fem_reference/solvers/multigrid/rigid_modes.hpp"
#include "fem_reference/solvers/multivector.hpp"
#include "fem_reference/solvers/saddle_point.hpp"

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

/// Of the solution on the coarse mesh, which is wrong by percents as it is.
constexpr double guess_tolerance = 1e-2;

std::vector<double> negative(std::vector<double> values) {
    std::ranges::transform(values, values.begin(), std::negate<>());
    return values;
}

/// (lanes) norm of each column
std::vector<double> size_of(const SaddlePointLoad &load, int lanes) {
    auto squares = dots(load.f, load.f, lanes);
    std::ranges::transform(squares, dots(load.g, load.g, lanes), squares.begin(), std::plus<>());
    return roots_of(squares);
}

} // namespace

/// Displacements and pressures of several columns, and the loads that they belong to.
struct MixedSolver::State {
    FreeUnknowns free;
    std::vector<std::size_t> constrained; ///< entries of displacements that are not free
    std::vector<double> load;             ///< (3 n, lanes)
    std::vector<double> u, p;             ///< (3 n, lanes), (m, lanes)
    /// (lanes) size of what is out of balance, of forces and volumes, where only what is constrained has moved
    std::vector<double> first_size;
    SaddlePointEnding ending{};
};

struct MixedSolver::Impl {
    Impl(const ElasticSystem &k, ChosenSolver &of_k, const PressureSystem &p, double of_residual)
        : system(k), solver(of_k), pressure(p), single_precision_divergence(rounded(p.divergence)),
          tolerance(of_residual), norm(pressure.norm) {
        const std::vector<double> all_free(static_cast<std::size_t>(pressure.num_pressures()),
                                           std::numeric_limits<double>::quiet_NaN());
        norm.factorise(all_free);
    }

    std::optional<State> approach(std::span<const Conditions> conditions, double to) const;
    std::optional<State> first_guess(std::span<const Conditions> conditions) const;

    /// What u and p leave of the load; nothing where unknowns are constrained.
    SaddlePointLoad left(const State &state, std::span<const double> u, std::span<const double> p) const {
        SaddlePointLoad out{std::vector<double>(u.size()), std::vector<double>(p.size())};
        matrix(state).apply(u, p, out.f, out.g);
        for (std::size_t i = 0; i < u.size(); ++i)
            out.f[i] = state.load[i] - out.f[i];
        zero(state.constrained, out.f);
        out.g = negative(std::move(out.g));
        return out;
    }
    SaddlePoint matrix(const State &state) const {
        return {solver, pressure, single_precision_divergence, state.free.lanes(), state.constrained};
    }

    const ElasticSystem &system;
    ChosenSolver &solver;
    const PressureSystem &pressure;
    DivergenceRows<float> single_precision_divergence;
    double tolerance;
    mutable ConstrainedSolver norm; ///< nothing is constrained
    MixedSolver *coarse = nullptr;  ///< and how to come from there, or nothing
    NestedIteration nested{};
};

MixedSolver::MixedSolver(const ElasticSystem &system, ChosenSolver &solver, const PressureSystem &pressure,
                         double tolerance)
    : impl_(std::make_unique<Impl>(system, solver, pressure, tolerance)) {}
MixedSolver::MixedSolver(const ElasticSystem &system, ChosenSolver &solver, const PressureSystem &pressure,
                         double tolerance, MixedSolver &coarse, NestedIteration nested)
    : impl_(std::make_unique<Impl>(system, solver, pressure, tolerance)) {
    impl_->coarse = &coarse;
    impl_->nested = std::move(nested);
}
MixedSolver::~MixedSolver() = default;
MixedSolver::MixedSolver(MixedSolver &&) noexcept = default;
MixedSolver &MixedSolver::operator=(MixedSolver &&) noexcept = default;

std::size_t MixedSolver::max_columns() const {
    return impl_->solver.max_columns();
}

/// The solution on the coarse mesh, nothing if there is none.
std::optional<MixedSolver::State> MixedSolver::Impl::first_guess(std::span<const Conditions> conditions) const {
    if (!coarse)
        return std::nullopt;
    const auto num_coarse = 3 * nested.displacement.fine_node.size();
    std::vector<std::vector<double>> prescribed, load;
    for (const auto &column : conditions) {
        auto &of_column = prescribed.emplace_back();
        for (const int node : nested.displacement.fine_node)
            of_column.insert(of_column.end(), &column.prescribed[3 * node], &column.prescribed[3 * node] + 3);
        nested.displacement.restrict_to(column.load, load.emplace_back(num_coarse));
    }
    std::vector<Conditions> on_coarse;
    for (std::size_t c = 0; c < conditions.size(); ++c)
        on_coarse.push_back({prescribed[c], load[c]});
    return coarse->impl_->approach(on_coarse, guess_tolerance);
}

/// Iterations on both at once.
/// @return nothing if the conditions do not fix the solution
std::optional<MixedSolver::State> MixedSolver::Impl::approach(std::span<const Conditions> conditions, double to) const {
    const auto guess = first_guess(conditions);
    std::vector<std::span<const double>> prescribed;
    for (const auto &column : conditions)
        prescribed.push_back(column.prescribed);
    const auto free = free_unknowns(prescribed);
    auto &inverse = solver.inverse();
    if (!inverse.set_up(free))
        return std::nullopt;

    const int lanes = free.lanes();
    State state{
        .free = free,
        .constrained = constrained_entries(free),
        .load = together(conditions, lanes, [](const auto &column, auto i) { return column.load[i]; }),
        .u = together(
            conditions, lanes,
            [](const auto &column, auto i) { return std::isnan(column.prescribed[i]) ? 0.0 : column.prescribed[i]; }),
        .p = std::vector<double>(static_cast<std::size_t>(lanes) * pressure.num_pressures(), 0.0),
        .first_size = {},
    };
    const auto whole = left(state, state.u, state.p);
    state.first_size = size_of(whole, lanes);
    if (guess) {
        std::vector<double> inside(state.u.size(), 0.0);
        nested.displacement.add_prolonged(guess->u, inside);
        zero(state.constrained, inside);
        for (std::size_t i = 0; i < inside.size(); ++i)
            state.u[i] += inside[i];
        state.p = nested.prolonged_pressure(guess->p, lanes);
    }
    std::vector<double> of_u(state.u.size()), of_p(state.p.size());
    state.ending = fem_reference::solve(matrix(state), inverse, norm, to, max_iterations, whole,
                                        guess ? left(state, state.u, state.p) : whole, of_u, of_p);
    for (std::size_t i = 0; i < of_u.size(); ++i)
        state.u[i] += of_u[i];
    for (std::size_t q = 0; q < of_p.size(); ++q)
        state.p[q] += of_p[q];
    return state;
}

ConstrainedSolution MixedSolver::solve(std::span<const double> prescribed, std::span<const double> load) {
    return std::move(solve(std::array{Conditions{prescribed, load}}).front());
}

std::vector<ConstrainedSolution> MixedSolver::solve(std::span<const Conditions> conditions) {
    std::vector<ConstrainedSolution> solutions(conditions.size());
    auto state = impl_->approach(conditions, impl_->tolerance);
    if (!state)
        return solutions;
    const int lanes = state->free.lanes();
    auto &u = state->u;
    balance(impl_->system, state->free, impl_->left(*state, u, state->p).f, u);

    std::vector<double> residual(u.size()), imbalance(state->p.size());
    impl_->matrix(*state).apply(u, state->p, residual, imbalance);
    for (std::size_t i = 0; i < u.size(); ++i)
        residual[i] -= state->load[i];
    SaddlePointLoad of_free{residual, std::move(imbalance)};
    zero(state->constrained, of_free.f);
    const auto last = size_of(of_free, lanes);
    const auto internal_work = dots(u, residual, lanes), external_work = dots(u, state->load, lanes);
    auto displacements = separated(u, lanes, conditions.size()),
         residuals = separated(residual, lanes, conditions.size());
    for (std::size_t c = 0; c < conditions.size(); ++c)
        solutions[c] = {.unique = true,
                        .displacement = std::move(displacements[c]),
                        .residual = std::move(residuals[c]),
                        .energy = 0.5 * (internal_work[c] + external_work[c]),
                        .converged = state->ending.converged,
                        .iterations = state->ending.iterations,
                        .relative_residual = state->first_size[c] > 0.0 ? last[c] / state->first_size[c] : 0.0};
    return solutions;
}

std::string MixedSolver::description(const ConstrainedSolution &solution) const {
    return fmt::format("GMRES, {} iterations, {} and the mass of the pressure", solution.iterations,
                       impl_->solver.inverse().name());
}

} // namespace livermark::fem_reference
