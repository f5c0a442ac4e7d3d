#include "fem_reference/solvers/constrained_solver.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "core/stopwatch.hpp"
#include "core/support/factors/sparse_cholesky.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/solvers/matrices.hpp"

namespace livermark::fem_reference {

namespace {

/// Below this ratio of the smallest to the largest pivot nothing but rounding is left of the smallest one: a body free
/// to move gave 5e-15 or less, a rod a hundred times longer than wide and constrained at one end 2e-8.
constexpr double singular_pivot_ratio = 1e-12;

using core::Clock;
using core::seconds_since;
using Solve = support::SparseCholesky::Solve;
constexpr std::array single_column{0};

std::vector<bool> free_of(std::span<const double> prescribed) {
    std::vector<bool> is_free(prescribed.size());
    for (std::size_t i = 0; i < prescribed.size(); ++i)
        is_free[i] = std::isnan(prescribed[i]);
    return is_free;
}

/// out = K u - f
std::vector<double> residual_of(const SymmetricMatrix &matrix, std::span<const double> u, std::span<const double> f) {
    std::vector<double> out(u.size());
    multiply(matrix, u, out);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] -= f[i];
    return out;
}

} // namespace

struct ConstrainedSolver::Impl {
    explicit Impl(SymmetricMatrix matrix) : stiffness(std::move(matrix)) {}

    void factorise(std::span<const double> prescribed);
    bool make_factor(const std::vector<bool> &is_free);
    template <class T>
    void solve(std::span<const T> load, std::span<T> u, int lanes, std::span<const int> columns, Solve solve) const;

    SymmetricMatrix stiffness;
    support::SparseCholesky factor;
    std::vector<bool> is_common; ///< (n) free in what prepare() was given; empty if nothing did
    std::vector<bool> is_row;    ///< (n) of the factor, empty if there is none
    std::vector<int> rows;       ///< of the factor
    bool is_definite = false;    ///< the factor
    std::vector<bool> is_free;   ///< (n) of the conditions in use: what is a row of the factor, or fewer
    bool unique = false;
    double factor_seconds = 0.0;
    double constrain_seconds = 0.0;
};

/// @return whether the stiffness of what is free is positive definite
bool ConstrainedSolver::Impl::make_factor(const std::vector<bool> &wanted) {
    if (wanted == is_row)
        return is_definite;
    const auto start = Clock::now();
    is_row.clear(); // what follows may throw
    rows.clear();
    std::vector<int> row_of(wanted.size(), -1);
    for (std::size_t i = 0; i < wanted.size(); ++i)
        if (wanted[i]) {
            row_of[i] = static_cast<int>(rows.size());
            rows.push_back(static_cast<int>(i));
        }
    is_definite = true;
    if (!rows.empty()) {
        // The upper triangle by columns; symmetry lets it be read from the rows.
        std::vector<int> column_start{0};
        std::vector<int> row;
        std::vector<double> value;
        for (const int dof : rows) {
            for (int k = stiffness.row_start[dof]; k < stiffness.row_start[dof + 1] && stiffness.column[k] <= dof; ++k)
                if (const int other = row_of[stiffness.column[k]]; other >= 0) {
                    row.push_back(other);
                    value.push_back(stiffness.value[k]);
                }
            column_start.push_back(static_cast<int>(row.size()));
        }
        const auto num_rows = static_cast<Eigen::Index>(rows.size());
        const Eigen::Map<const Eigen::SparseMatrix<double>> upper(
            num_rows, num_rows, static_cast<Eigen::Index>(row.size()), column_start.data(), row.data(), value.data());
        factor.order(upper);
        is_definite = factor.factorise(upper) && factor.pivot_ratio() > singular_pivot_ratio;
    }
    is_row = wanted;
    factor_seconds = seconds_since(start);
    return is_definite;
}

void ConstrainedSolver::Impl::factorise(std::span<const double> prescribed) {
    auto wanted = free_of(prescribed);
    if (wanted == is_free)
        return;
    is_free.clear(); // what follows may throw
    auto constrained = is_common.empty() ? std::nullopt : support::unknowns_to_constrain(is_common, wanted);
    unique = constrained && make_factor(is_common);
    if (!unique) {
        constrained.reset();
        unique = make_factor(wanted);
    }
    const auto start = Clock::now();
    if (unique && !rows.empty())
        factor.constrain(std::move(constrained).value_or(std::vector<int>{}));
    constrain_seconds = seconds_since(start);
    is_free = std::move(wanted);
}

template <class T>
void ConstrainedSolver::Impl::solve(std::span<const T> load, std::span<T> u, int lanes, std::span<const int> columns,
                                    Solve solve) const {
    for (const int column : columns)
        for (std::size_t entry = column; entry < u.size(); entry += lanes)
            u[entry] = T(0);
    if (rows.empty())
        return;
    Eigen::MatrixXd values(rows.size(), columns.size());
    for (std::size_t c = 0; c < columns.size(); ++c)
        for (std::size_t r = 0; r < rows.size(); ++r)
            values(r, c) = load[static_cast<std::size_t>(lanes) * rows[r] + columns[c]];
    values = (factor.*solve)(values);
    for (std::size_t c = 0; c < columns.size(); ++c)
        for (std::size_t r = 0; r < rows.size(); ++r)
            u[static_cast<std::size_t>(lanes) * rows[r] + columns[c]] = static_cast<T>(values(r, c));
}

ConstrainedSolver::ConstrainedSolver(SymmetricMatrix stiffness) : impl_(std::make_unique<Impl>(std::move(stiffness))) {}
ConstrainedSolver::~ConstrainedSolver() = default;
ConstrainedSolver::ConstrainedSolver(ConstrainedSolver &&) noexcept = default;
ConstrainedSolver &ConstrainedSolver::operator=(ConstrainedSolver &&) noexcept = default;

void ConstrainedSolver::prepare(std::span<const double> prescribed) {
    impl_->is_common = free_of(prescribed);
}

bool ConstrainedSolver::factorise(std::span<const double> prescribed) {
    impl_->factorise(prescribed);
    return impl_->unique;
}

void ConstrainedSolver::solve_constrained(std::span<const double> load, std::span<double> u) {
    impl_->solve(load, u, 1, single_column, &support::SparseCholesky::solve);
}

void ConstrainedSolver::solve_single_precision(std::span<const float> load, std::span<float> u, int lanes,
                                               std::span<const int> columns) {
    impl_->solve(load, u, lanes, columns, &support::SparseCholesky::solve_single_precision);
}

void ConstrainedSolver::solve_single_precision(std::span<const double> load, std::span<double> u) {
    impl_->solve(load, u, 1, single_column, &support::SparseCholesky::solve_single_precision);
}

ConstrainedSolution ConstrainedSolver::solve(std::span<const double> prescribed, std::span<const double> load) {
    impl_->factorise(prescribed);
    ConstrainedSolution solution;
    solution.unique = impl_->unique;
    if (!solution.unique)
        return solution;

    auto &u = solution.displacement;
    u.resize(prescribed.size());
    for (std::size_t i = 0; i < u.size(); ++i)
        u[i] = impl_->is_free[i] ? 0.0 : prescribed[i];
    const auto imbalance = residual_of(impl_->stiffness, u, load);
    std::vector<double> correction(u.size());
    solve_constrained(imbalance, correction);
    for (std::size_t i = 0; i < u.size(); ++i)
        u[i] -= correction[i];
    solution.residual = residual_of(impl_->stiffness, u, load);
    solution.energy = 0.5 * (dot(u, solution.residual) + dot(u, load));
    return solution;
}

double ConstrainedSolver::factor_seconds() const {
    return impl_->factor_seconds + impl_->constrain_seconds;
}

} // namespace livermark::fem_reference
