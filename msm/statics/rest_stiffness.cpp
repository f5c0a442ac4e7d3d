#include "msm/statics/rest_stiffness.hpp"

#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "core/bounding_box.hpp"

namespace livermark::msm {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

} // namespace

RestStiffness::RestStiffness(Eigen::SparseMatrix<double> stiffness, const std::vector<core::Vector3> &positions,
                             std::vector<core::Vector3> common)
    : extent_(core::extent(positions)), common_(std::move(common)) {
    stiffness_.swap(stiffness); // Eigen does not move sparse matrices
}

RestStiffness::RestStiffness(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                             const std::vector<core::Vector3> &prescribed)
    : RestStiffness(elastic_hessian(body, positions, Tangent::exact), positions, {}) {
    constrain(prescribed);
}

/// @return whether the stiffness of these components is positive definite
bool RestStiffness::factorise(const FreeComponents &rows) {
    if (rows_ == rows)
        return rows_are_definite_;
    rows_.reset(); // what follows may throw
    const auto start = Clock::now();
    const auto restricted = rows.restrict(stiffness_);
    factor_.order(restricted);
    rows_are_definite_ = factor_.factorise(restricted);
    rows_ = rows;
    factor_seconds_ = seconds_since(start);
    return rows_are_definite_;
}

void RestStiffness::constrain(const std::vector<core::Vector3> &prescribed) {
    if (constrains(prescribed))
        return;
    free_ = FreeComponents(prescribed);
    double square = 0.0;
    for (Eigen::Index c = 0; c < stiffness_.rows(); ++c)
        if (free_.is_free(c))
            square += stiffness_.coeff(c, c) * stiffness_.coeff(c, c);
    rounding_force_ = std::numeric_limits<double>::epsilon() * extent_ * std::sqrt(square);

    const FreeComponents common(common_);
    auto constrained =
        common_.empty() ? std::nullopt : support::unknowns_to_constrain(common.are_free(), free_.are_free());
    is_definite_ = constrained && factorise(common);
    if (!is_definite_) {
        constrained.reset();
        is_definite_ = factorise(free_);
    }
    const auto start = Clock::now();
    if (is_definite_)
        factor_.constrain(std::move(constrained).value_or(std::vector<int>{}));
    constrain_seconds_ = seconds_since(start);
}

Eigen::VectorXd RestStiffness::inverse_times(const Eigen::VectorXd &force) const {
    return inverse_times(force, &support::SparseCholesky::solve_single_precision);
}

Eigen::VectorXd RestStiffness::inverse_times(const Eigen::VectorXd &force, support::SparseCholesky::Solve solve) const {
    Eigen::VectorXd of_rows = Eigen::VectorXd::Zero(rows_->size());
    for (Eigen::Index c = 0; c < stiffness_.rows(); ++c)
        if (free_.is_free(c))
            of_rows[rows_->number(c)] = force[free_.number(c)];
    of_rows = (factor_.*solve)(of_rows);
    Eigen::VectorXd solution(force.size());
    for (Eigen::Index c = 0; c < stiffness_.rows(); ++c)
        if (free_.is_free(c))
            solution[free_.number(c)] = of_rows[rows_->number(c)];
    return solution;
}

bool RestStiffness::constrains(const std::vector<core::Vector3> &prescribed) const {
    return rows_ && free_ == FreeComponents(prescribed);
}

std::vector<core::Vector3> RestStiffness::solve(const std::vector<core::Vector3> &prescribed,
                                                const std::vector<core::Vector3> &force) const {
    auto displacement = prescribed;
    for (auto &node : displacement)
        node = node.array().isNaN().select(core::Vector3::Zero(), node);
    if (!is_definite_)
        return displacement;
    const Eigen::VectorXd load = to_unknowns(force) - stiffness_ * to_unknowns(displacement);
    free_.add(displacement, inverse_times(free_.gather(to_field(load)), &support::SparseCholesky::solve), 1.0);
    return displacement;
}

} // namespace livermark::msm
