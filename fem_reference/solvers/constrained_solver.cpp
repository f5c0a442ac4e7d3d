#include "fem_reference/solvers/constrained_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

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

BlockFactor::BlockFactor(const LowerRows &rows, std::vector<bool> is_free)
    : is_free_(std::move(is_free)), number_(is_free_.size(), -1) {
    for (std::size_t dof = 0; dof < is_free_.size(); ++dof)
        if (is_free_[dof])
            number_[dof] = num_free_++;
    for (std::size_t a = 0; a < rows.num_nodes(); ++a)
        for (int i = 0; i < 3; ++i) {
            if (!is_free_[3 * a + i])
                continue;
            start_.push_back(static_cast<int>(entry_.size()));
            for (int k = rows.row_start[a]; k < rows.row_start[a + 1]; ++k)
                for (int j = 0; j < 3; ++j)
                    if (const int column = number_[3 * rows.column[k] + j]; column >= 0)
                        entry_.push_back(column);
            for (int j = 0; j <= i; ++j)
                if (const int column = number_[3 * a + j]; column >= 0)
                    entry_.push_back(column);
        }
    start_.push_back(static_cast<int>(entry_.size()));
}

bool BlockFactor::factorise(const SymmetricBlocks<double> &matrix) {
    const auto &rows = matrix.rows;
    std::vector<double> value;
    value.reserve(entry_.size());
    for (std::size_t a = 0; a < rows.num_nodes(); ++a)
        for (int i = 0; i < 3; ++i) {
            if (!is_free_[3 * a + i])
                continue;
            for (int k = rows.row_start[a]; k < rows.row_start[a + 1]; ++k)
                for (int j = 0; j < 3; ++j)
                    if (is_free_[3 * rows.column[k] + j])
                        value.push_back(matrix.below[k][3 * i + j]);
            for (int j = 0; j <= i; ++j)
                if (is_free_[3 * a + j])
                    value.push_back(matrix.diagonal[a][3 * i + j]);
        }
    const Eigen::Map<const Eigen::SparseMatrix<double>> upper(
        num_free_, num_free_, static_cast<Eigen::Index>(value.size()), start_.data(), entry_.data(), value.data());
    if (!is_ordered_)
        cholesky_.order(upper);
    is_ordered_ = true;
    return cholesky_.factorise(upper);
}

void BlockFactor::solve(std::span<const double> b, std::span<double> x) const {
    Eigen::VectorXd free_values(num_free_);
    for (std::size_t dof = 0; dof < b.size(); ++dof)
        if (number_[dof] >= 0)
            free_values[number_[dof]] = b[dof];
    free_values = cholesky_.solve_single_precision(free_values);
    for (std::size_t dof = 0; dof < b.size(); ++dof)
        x[dof] = number_[dof] >= 0 ? free_values[number_[dof]] : 0.0;
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

IterativeSolver::IterativeSolver(const SymmetricBlocks<double> &stiffness,
                                 std::unique_ptr<Preconditioner> preconditioner, int max_iterations)
    : stiffness_(stiffness), preconditioner_(std::move(preconditioner)), max_iterations_(max_iterations) {}

bool IterativeSolver::set_up(std::span<const double> prescribed) {
    const auto start = Clock::now();
    auto wanted = free_unknowns(std::array{prescribed});
    const bool is_new = wanted != free_;
    free_ = {}; // what follows may throw
    // The preconditioner knows best whether it is still what it was: it may share parts with another one.
    const bool unique = preconditioner_->set_up(wanted);
    free_ = std::move(wanted);
    if (is_new)
        setup_seconds_ = seconds_since(start);
    return unique;
}

/// Conjugate gradients (Hestenes and Stiefel 1952). Each direction is made conjugate to the last one outright, which
/// forgives a preconditioner that is symmetric only to single precision.
IterativeSolver::Ending IterativeSolver::add_solution(std::span<double> residual, std::span<double> u,
                                                      std::span<const std::size_t> constrained, double size,
                                                      double goal) {
    Ending ending{.relative_residual = size > 0.0 ? std::sqrt(dot(residual, residual)) / size : 0.0};
    std::vector<double> direction(u.size(), 0.0), image(u.size(), 0.0);
    std::vector<float> unit_residual(u.size()), correction(u.size()); // the residual over its size
    double curvature = 1.0;                                           // p^T K p
    while (ending.relative_residual > goal && ending.iterations < max_iterations_) {
        const double left = ending.relative_residual * size;
        for (std::size_t i = 0; i < u.size(); ++i)
            unit_residual[i] = static_cast<float>(residual[i] / left);
        preconditioner_->apply(unit_residual, correction);
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
