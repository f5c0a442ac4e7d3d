#include "msm/rest_stiffness.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "msm/extent.hpp"

namespace livermark::msm {

RestStiffness::RestStiffness(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                             const std::vector<core::Vector3> &prescribed)
    : RestStiffness(
          std::make_shared<const Eigen::SparseMatrix<double>>(elastic_hessian(body, positions, Tangent::exact)),
          positions, prescribed) {}

RestStiffness::RestStiffness(std::shared_ptr<const Eigen::SparseMatrix<double>> stiffness,
                             const std::vector<core::Vector3> &positions, const std::vector<core::Vector3> &prescribed)
    : free_(prescribed), stiffness_(std::move(stiffness)) {
    const auto restricted = free_.restrict(*stiffness_);
    rounding_force_ = std::numeric_limits<double>::epsilon() * extent(positions) * restricted.diagonal().norm();
    is_definite_ = factor_.factorize(restricted);
}

bool RestStiffness::holds(const std::vector<core::Vector3> &prescribed) const {
    for (std::size_t i = 0; i < prescribed.size(); ++i)
        for (int c = 0; c < 3; ++c)
            if (std::isnan(prescribed[i][c]) != free_.is_free(static_cast<Eigen::Index>(3 * i) + c))
                return false;
    return true;
}

std::vector<core::Vector3> RestStiffness::solve(const std::vector<core::Vector3> &prescribed,
                                                const std::vector<core::Vector3> &force) const {
    auto displacement = prescribed;
    for (auto &node : displacement)
        node = node.array().isNaN().select(core::Vector3::Zero(), node);
    if (!is_definite_)
        return displacement;
    const Eigen::VectorXd load = to_unknowns(force) - *stiffness_ * to_unknowns(displacement);
    free_.add(displacement, factor_.solve(free_.gather(to_field(load))), 1.0);
    return displacement;
}

} // namespace livermark::msm
