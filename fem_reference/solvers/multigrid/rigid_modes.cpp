#include "fem_reference/solvers/multigrid/rigid_modes.hpp"

#include <Eigen/Cholesky>
#include <vector>

#include "core/mesh/bounding_box.hpp"

namespace livermark::fem_reference {

namespace {

using Six = Eigen::Matrix<double, RigidModes::count, 1>;
using Gram = Eigen::Matrix<double, RigidModes::count, RigidModes::count>;

/// R_h^T K_hh R_h
Gram stiffness_of_constrained(const ElasticSystem &system, const RigidModes &modes, const std::vector<bool> &is_free) {
    const auto &[rows, below, diagonal] = system.stiffness;
    /// R_a^T K_ab R_b of what is constrained of two nodes
    const auto of_block = [&](int a, int b, const Block<double> &block) -> Gram {
        const auto constrained = [&](int node) {
            auto at_node = modes.at(system.points[node]);
            for (int i = 0; i < 3; ++i)
                if (is_free[3 * node + i])
                    at_node.row(i).setZero();
            return at_node;
        };
        return constrained(a).transpose() * Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(block.data()) *
               constrained(b);
    };
    const auto is_constrained = [&](int node) {
        return !(is_free[3 * node] && is_free[3 * node + 1] && is_free[3 * node + 2]);
    };
    Gram gram = Gram::Zero();
    for (int node = 0; node < system.num_nodes(); ++node) {
        if (!is_constrained(node))
            continue;
        gram += of_block(node, node, diagonal[node]);
        for (int k = rows.row_start[node]; k < rows.row_start[node + 1]; ++k)
            if (is_constrained(rows.column[k])) {
                const Gram part = of_block(node, rows.column[k], below[k]);
                gram += part + part.transpose();
            }
    }
    return gram;
}

} // namespace

RigidModes::RigidModes(std::span<const core::Vector3> points) {
    const auto box = core::bounding_box(points);
    middle_ = box.center();
    size_ = box.diagonal().norm();
}

Eigen::Matrix<double, 3, RigidModes::count> RigidModes::at(const core::Vector3 &point) const {
    const core::Vector3 arm = (point - middle_) / size_;
    Eigen::Matrix<double, 3, count> modes;
    modes.leftCols<3>().setIdentity();
    for (int axis = 0; axis < 3; ++axis)
        modes.col(3 + axis) = core::Vector3::Unit(axis).cross(arm);
    return modes;
}

void balance(const ElasticSystem &system, const FreeUnknowns &free, std::span<const double> residual,
             std::span<double> u) {
    const RigidModes modes(system.points);
    const auto lanes = static_cast<std::size_t>(free.lanes());
    std::vector<Six> motion(lanes, Six::Zero()); // first what is out of balance
    for (std::size_t node = 0; node < system.points.size(); ++node) {
        const auto at_node = modes.at(system.points[node]);
        for (int i = 0; i < 3; ++i)
            for (std::size_t c = 0; c < lanes; ++c)
                motion[c] += residual[lanes * (3 * node + i) + c] * at_node.row(i).transpose();
    }
    std::vector<Eigen::LDLT<Gram>> factors;
    for (const auto &set : free.sets)
        factors.emplace_back(stiffness_of_constrained(system, modes, set));
    for (std::size_t c = 0; c < lanes; ++c)
        motion[c] = factors[free.set[c]].solve(motion[c]);
    for (std::size_t node = 0; node < system.points.size(); ++node) {
        const auto at_node = modes.at(system.points[node]);
        for (int i = 0; i < 3; ++i)
            for (std::size_t c = 0; c < lanes; ++c)
                if (free.sets[free.set[c]][3 * node + i])
                    u[lanes * (3 * node + i) + c] += at_node.row(i).dot(motion[c]);
    }
}

} // namespace livermark::fem_reference
