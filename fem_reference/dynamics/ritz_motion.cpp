#include "fem_reference/dynamics/ritz_motion.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <vector>

namespace livermark::fem_reference {

namespace {

constexpr double motion_tolerance = 5e-5;
constexpr int vectors_per_check = 5;
constexpr int vectors_left_out = 10; ///< of the motion that a check compares with
/// Where what the vectors change begins to go down at the pace that it keeps.
constexpr int fewest_to_extrapolate = 40;
/// A probe that moves less than this part of the one that moves most counts as if it moved that much.
constexpr double least_part = 1e-3;

/// What the last vectors change in the motion of the whole body and of each probe, the largest of these parts.
double largest_change(const RitzSpace &space, const core::Release &release) {
    const auto num_probes = static_cast<Eigen::Index>(release.probes.size());
    Eigen::MatrixXd of_probes(3 * num_probes, space.size());
    for (Eigen::Index q = 0; q < num_probes; ++q)
        of_probes.middleRows<3>(3 * q) =
            space.vectors().middleRows<3>(3 * static_cast<Eigen::Index>(release.probes[q].node));

    const Eigen::Index num_before = space.size() - vectors_left_out;
    auto motion = motion_in(space, space.size(), release);
    auto motion_before = motion_in(space, num_before, release);
    double moved = 0.0, changed = 0.0; // squares, summed over time; V is orthonormal
    Eigen::ArrayXd probe_moved = Eigen::ArrayXd::Zero(num_probes), probe_changed = probe_moved;
    for (int step = 0; step < release.num_steps; ++step) {
        motion.advance();
        motion_before.advance();
        const Eigen::VectorXd z = motion.displacement();
        Eigen::VectorXd change = z;
        change.head(num_before) -= motion_before.displacement();
        moved += z.squaredNorm();
        changed += change.squaredNorm();
        const Eigen::VectorXd probes = of_probes * z, change_of_probes = of_probes * change;
        probe_moved += probes.reshaped(3, num_probes).colwise().squaredNorm().transpose().array();
        probe_changed += change_of_probes.reshaped(3, num_probes).colwise().squaredNorm().transpose().array();
    }
    double largest = changed / moved;
    const double least = least_part * least_part * (num_probes > 0 ? probe_moved.maxCoeff() : 0.0);
    for (Eigen::Index q = 0; q < num_probes; ++q)
        if (probe_changed[q] > 0.0)
            largest = std::max(largest, probe_changed[q] / std::max(probe_moved[q], least));
    return std::sqrt(largest);
}

} // namespace

RitzMotion::RitzMotion(const Eigen::MatrixXd &stiffness, const Eigen::VectorXd &force,
                       const core::RayleighDamping &damping, double time_step)
    : time_step_(time_step), displacement_(Eigen::ArrayXd::Zero(force.size())), velocity_(displacement_) {
    if (force.size() == 0)
        return;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(stiffness);
    modes_ = solver.eigenvectors();
    square_ = solver.eigenvalues();
    force_ = modes_.transpose() * force;
    effective_ = 2.0 / time_step + damping.alpha + (damping.beta + 0.5 * time_step) * square_;
}

void RitzMotion::advance() {
    const Eigen::ArrayXd mean_velocity = (2.0 / time_step_ * velocity_ + force_ - square_ * displacement_) / effective_;
    displacement_ += time_step_ * mean_velocity;
    velocity_ = 2.0 * mean_velocity - velocity_;
}

RitzMotion motion_in(const RitzSpace &space, Eigen::Index num_vectors, const core::Release &release) {
    return {space.stiffness().topLeftCorner(num_vectors, num_vectors), space.force().head(num_vectors), release.damping,
            release.output_interval};
}

bool extend_until_converged(RitzSpace &space, const core::Release &release) {
    const int most = release.num_steps / 2; // a vector costs as much as one or two steps
    std::vector<double> changes;
    for (int size = vectors_per_check; size <= most; size += vectors_per_check) {
        while (space.size() < size)
            if (!space.extend())
                return true;
        if (size <= vectors_left_out)
            continue;
        changes.push_back(largest_change(space, release));
        if (changes.back() < motion_tolerance)
            return true;
        if (size >= fewest_to_extrapolate) {
            const double before = changes.end()[-1 - vectors_left_out / vectors_per_check];
            const double decades_per_vector = std::log10(before / changes.back()) / vectors_left_out;
            if (!(decades_per_vector * (most - size) > std::log10(changes.back() / motion_tolerance)))
                return false;
        }
    }
    return false;
}

} // namespace livermark::fem_reference
