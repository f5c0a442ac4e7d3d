#include "msm/dynamics/highest_frequency.hpp"

#include <Spectra/SymEigsSolver.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>

#include "msm/statics/free_components.hpp"

namespace livermark::msm {

namespace {

using Field = std::vector<core::Vector3>;
/// omega, and M^1/2 phi of the free components, of length 1.
using Pair = std::pair<double, Eigen::VectorXd>;

/// Of the largest omega^2: its residual bounds the error of an eigenvalue.
constexpr double largest_tolerance = 1e-9;
constexpr int most_restarts = 1000;
constexpr Eigen::Index num_vectors_for_largest = 40;

/// y = M^-1/2 K M^-1/2 x, term by term, as Spectra asks for it.
class ScaledStiffness {
  public:
    using Scalar = double;
    ScaledStiffness(const ElasticBody &body, const Field &positions, const FreeComponents &free,
                    const MassScaling &scaling)
        : stiffness_(body, positions), free_(free), num_nodes_(positions.size()), node_mass_(body.node_mass),
          inverse_root_mass_(inverse_root_mass(body.node_mass, free)), scaling_(scaling),
          rest_(to_unknowns(positions)) {}

    Eigen::Index rows() const { return free_.size(); }
    Eigen::Index cols() const { return free_.size(); }
    void perform_op(const double *x, double *y) const {
        displacement_.assign(num_nodes_, core::Vector3::Zero());
        free_.add(displacement_, Eigen::VectorXd::Map(x, rows()).cwiseProduct(inverse_root_mass_), 1.0);
        Eigen::VectorXd moved = to_unknowns(displacement_);
        scale_deformation(scaling_, -0.5, rest_, moved);
        Eigen::VectorXd force = stiffness_.times(moved);
        // M^1/2 (Q + (I - Q) f^-1/2) M^-1, the transpose of what made the displacement
        scale_by_mass(force, -1.0);
        scale_deformation(scaling_, -0.5, rest_, force);
        scale_by_mass(force, 1.0);
        Eigen::VectorXd::Map(y, rows()) = free_.gather(to_field(force)).cwiseProduct(inverse_root_mass_);
    }

  private:
    void scale_by_mass(Eigen::VectorXd &field, double power) const {
        if (!scaling_.parts.empty())
            for (std::size_t i = 0; i < num_nodes_; ++i)
                of_node(field, static_cast<int>(i)) *= std::pow(node_mass_[i], power);
    }

    StiffnessProduct stiffness_;
    const FreeComponents &free_;
    std::size_t num_nodes_;
    const std::vector<double> &node_mass_;
    Eigen::VectorXd inverse_root_mass_;
    MassScaling scaling_;
    Eigen::VectorXd rest_;
    mutable Field displacement_;
};

/// Lanczos's method has no room in fewer unknowns than it keeps vectors, but there the matrix can be written down.
Pair highest_of_few(const ScaledStiffness &stiffness) {
    Eigen::MatrixXd matrix(stiffness.rows(), stiffness.cols());
    const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
    for (Eigen::Index c = 0; c < matrix.cols(); ++c)
        stiffness.perform_op(unit.col(c).data(), matrix.col(c).data());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix); // ascending
    return {std::sqrt(std::max(0.0, solver.eigenvalues()[matrix.rows() - 1])),
            solver.eigenvectors().col(matrix.rows() - 1)};
}

Pair highest_pair(const ElasticBody &body, const Field &positions, const FreeComponents &free,
                  const MassScaling &scaling = {}, double tolerance = largest_tolerance) {
    if (free.size() == 0)
        return {};
    ScaledStiffness stiffness(body, positions, free, scaling);
    if (free.size() <= num_vectors_for_largest)
        return highest_of_few(stiffness);
    // Three are asked for, so that a near copy of the largest is told from it and does not slow it down.
    Spectra::SymEigsSolver<ScaledStiffness> lanczos(stiffness, 3, num_vectors_for_largest);
    lanczos.init(); // from a random vector of fixed seed
    lanczos.compute(Spectra::SortRule::LargestAlge, most_restarts, tolerance, Spectra::SortRule::LargestAlge);
    if (lanczos.info() != Spectra::CompInfo::Successful)
        throw std::runtime_error(
            fmt::format("the largest frequency did not converge in {} restarts of Lanczos's method", most_restarts));
    return {std::sqrt(lanczos.eigenvalues()[0]), lanczos.eigenvectors(1)};
}

} // namespace

HighestMode highest_mode(const ElasticBody &body, const Field &positions, const NodalConditions &conditions) {
    HighestMode mode;
    mode.free = FreeComponents(conditions.displacement);
    const auto [frequency, shape] = highest_pair(body, positions, mode.free);
    mode.angular_frequency = frequency;
    Field field(positions.size(), core::Vector3::Zero());
    mode.free.add(field, shape, 1.0);
    mode.shape = to_unknowns(field);
    return mode;
}

double largest_angular_frequency(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                 const MassScaling &scaling, double tolerance) {
    return highest_pair(body, positions, FreeComponents(conditions.displacement), scaling, tolerance).first;
}

double largest_angular_frequency(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                                 const HighestMode &of_less) {
    const FreeComponents free(conditions.displacement);
    const auto is_free = free.are_free(), was_free = of_less.free.are_free();
    const bool constrains_more = std::ranges::equal(is_free, was_free, [](bool is, bool was) { return was || !is; });
    const Eigen::VectorXd trial = free.gather(to_field(of_less.shape));
    Eigen::VectorXd image(free.size());
    if (constrains_more && trial.squaredNorm() > 0.0) {
        ScaledStiffness(body, positions, free, {}).perform_op(trial.data(), image.data());
        const double above = of_less.angular_frequency * of_less.angular_frequency;
        const double below = trial.dot(image) / trial.squaredNorm();
        if (above - below <= largest_tolerance * above)
            return of_less.angular_frequency;
    }
    return largest_angular_frequency(body, positions, conditions);
}

std::vector<double> nodal_frequency_bounds(const ElasticBody &body, const Field &positions,
                                           const NodalConditions &conditions) {
    std::vector<Eigen::Matrix3d> block(body.node_mass.size(), Eigen::Matrix3d::Zero());
    for (const auto &term : body.terms)
        term->add_block_bound(to_unknowns(positions), block);
    std::vector<double> bounds;
    for (std::size_t i = 0; i < block.size(); ++i) {
        for (int c = 0; c < 3; ++c)
            if (!std::isnan(conditions.displacement[i][c])) {
                block[i].row(c).setZero();
                block[i].col(c).setZero();
            }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(block[i], Eigen::EigenvaluesOnly);
        bounds.push_back(std::sqrt(std::max(0.0, eigen.eigenvalues()[2] / body.node_mass[i])));
    }
    return bounds;
}

double gershgorin_angular_frequency(const ElasticBody &body, const Field &positions,
                                    const NodalConditions &conditions) {
    const auto bounds = nodal_frequency_bounds(body, positions, conditions);
    return bounds.empty() ? 0.0 : *std::ranges::max_element(bounds);
}

} // namespace livermark::msm
