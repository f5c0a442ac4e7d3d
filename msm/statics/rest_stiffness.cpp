#include "msm/statics/rest_stiffness.hpp"

#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "core/mesh/bounding_box.hpp"
#include "msm/statics/conjugate_gradients.hpp"

namespace livermark::msm {

namespace {

/// Of the residual of the linear answer, where it is found step by step.
constexpr double linear_tolerance = 1e-10;
constexpr int most_conjugate_gradients = 300;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// About what is on the diagonal of the stiffness, without the stiffness. The bounds of tetrahedra are four times it.
Eigen::VectorXd bound_of_diagonal(const ElasticBody &body, const std::vector<core::Vector3> &positions) {
    std::vector<Eigen::Matrix3d> blocks(positions.size(), Eigen::Matrix3d::Zero());
    for (const auto &term : body.terms)
        term->add_block_bound(to_unknowns(positions), blocks);
    std::vector<core::Vector3> diagonal;
    for (const auto &block : blocks)
        diagonal.emplace_back(0.25 * block.diagonal());
    return to_unknowns(diagonal);
}

} // namespace

RestStiffness::RestStiffness(const ElasticBody &body, const std::vector<core::Vector3> &positions)
    : extent_(core::extent(positions)) {
    auto stiffness = body.preconditioner ? body.preconditioner->hessian(to_unknowns(positions), Tangent::material)
                                         : elastic_hessian(body, positions, Tangent::exact);
    stiffness_.swap(stiffness); // Eigen does not move sparse matrices
    if (!body.preconditioner)
        diagonal_ = stiffness_.diagonal();
    else {
        product_.emplace(body, positions);
        diagonal_ = bound_of_diagonal(body, positions);
    }
}

RestStiffness RestStiffness::of_many(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                     std::vector<core::Vector3> common) {
    RestStiffness rest(body, positions);
    rest.common_ = std::move(common);
    return rest;
}

RestStiffness::RestStiffness(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                             const std::vector<core::Vector3> &prescribed)
    : RestStiffness(body, positions) {
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
            square += diagonal_[c] * diagonal_[c];
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
                                                const std::vector<core::Vector3> &force, LimitedMemory *memory) const {
    auto displacement = prescribed;
    for (auto &node : displacement)
        node = node.array().isNaN().select(core::Vector3::Zero(), node);
    if (!is_definite_)
        return displacement;
    const Eigen::VectorXd load = free_.gather(to_field(to_unknowns(force) - product(to_unknowns(displacement))));
    free_.add(displacement,
              product_ ? by_conjugate_gradients(load, memory) : inverse_times(load, &support::SparseCholesky::solve),
              1.0);
    return displacement;
}

Eigen::VectorXd RestStiffness::product(const Eigen::VectorXd &displacement) const {
    return product_ ? product_->times(displacement) : Eigen::VectorXd(stiffness_ * displacement);
}

Eigen::VectorXd RestStiffness::by_conjugate_gradients(const Eigen::VectorXd &load, LimitedMemory *memory) const {
    const std::vector<core::Vector3> nothing(static_cast<std::size_t>(stiffness_.rows() / 3), core::Vector3::Zero());
    const auto matrix = [&](const Eigen::VectorXd &displacement) {
        auto field = nothing;
        free_.add(field, displacement, 1.0);
        return free_.gather(to_field(product_->times(to_unknowns(field))));
    };
    return conjugate_gradients(
        matrix, [this](const auto &vector) { return inverse_times(vector); }, load, linear_tolerance,
        most_conjugate_gradients,
        [memory](const auto &step, const auto &change) {
            if (memory)
                memory->learn(step, change);
        });
}

} // namespace livermark::msm
