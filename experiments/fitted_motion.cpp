#include "experiments/fitted_motion.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <fmt/ranges.h>

#include "core/mesh/patches.hpp"
#include "support/input_error.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;

Vector3 mean(std::span<const Vector3> vectors) {
    Vector3 sum = Vector3::Zero();
    for (const auto &vector : vectors)
        sum += vector;
    return sum / static_cast<double>(vectors.size());
}

int num_coefficients(int degree) {
    return (degree + 1) * (degree + 2) / 2;
}

} // namespace

FittedMotion::FittedMotion(std::span<const Vector3> positions, std::span<const Vector3> displacements, int degree,
                           const std::string &place)
    : degree_(degree), middle_(mean(positions)) {
    const int needed = num_coefficients(degree);
    const auto count = static_cast<int>(positions.size());
    const auto refuse = [&](const std::string &fault) {
        throw support::InputError(
            fmt::format("{}: {}; take a polynomial of lower degree, or more markers", place, fault));
    };
    if (count < needed)
        refuse(fmt::format("{} markers do not determine the {} coefficients of a polynomial of degree {}", count,
                           needed, degree));
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const auto &position : positions)
        spread += (position - middle_) * (position - middle_).transpose() / count;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread); // ascending
    for (int axis = 0; axis < 2; ++axis) {
        const double length = std::sqrt(std::max(axes.eigenvalues()[2 - axis], 0.0));
        axes_.row(axis) = axes.eigenvectors().col(2 - axis).transpose() / (length > 0.0 ? length : 1.0);
    }
    Eigen::MatrixXd basis(count, needed);
    Eigen::MatrixX3d moved(count, 3);
    for (int k = 0; k < count; ++k) {
        basis.row(k) = monomials(positions[k]);
        moved.row(k) = displacements[k].transpose();
    }
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor(basis);
    factor.setThreshold(1e-8);
    if (factor.rank() < needed)
        refuse(
            fmt::format("its {} markers lie so that they do not determine a polynomial of degree {}", count, degree));
    coefficients_ = factor.solve(moved);
    residual_ = std::sqrt((basis * coefficients_ - moved).squaredNorm() / count);
}

Eigen::RowVectorXd FittedMotion::monomials(const Vector3 &point) const {
    const Eigen::Vector2d along = axes_ * (point - middle_);
    Eigen::RowVectorXd values(num_coefficients(degree_));
    int next = 0;
    for (int a = 0; a <= degree_; ++a)
        for (int b = 0; a + b <= degree_; ++b)
            values[next++] = std::pow(along[0], a) * std::pow(along[1], b);
    return values;
}

Vector3 FittedMotion::at(const Vector3 &point) const {
    return (monomials(point) * coefficients_).transpose();
}

void drive(core::LoadCase &load_case, const core::TetraMesh &mesh, const PlaceMotion &place) {
    const auto facets = core::facets_in_patch(mesh, place.patch);
    if (facets.empty())
        throw support::InputError(fmt::format("markers drive '{}', and the body has no such patch; it has {}",
                                              support::shown(place.patch), fmt::join(core::patches_of(mesh), ", ")));
    load_case.node_shift.resize(mesh.points.size(), Vector3::Zero());
    for (const int f : facets) {
        if (!load_case.is_constrained(f))
            throw support::InputError(fmt::format("markers drive '{}', and nothing constrains it; give it a "
                                                  "[[condition]] with displacement = [0.0, 0.0, 0.0]",
                                                  place.patch));
        for (const int node : mesh.boundary_triangles[f])
            load_case.node_shift[node] = place.motion.at(mesh.points[node]);
    }
}

Vector3 straight_line(const PlaceMotion &from, const PlaceMotion &to, const Vector3 &point) {
    const Vector3 way = to.motion.middle() - from.motion.middle();
    const double part = (point - from.motion.middle()).dot(way) / way.squaredNorm();
    return (1.0 - part) * from.motion.at(point) + part * to.motion.at(point);
}

RigidMotion best_rigid_motion(std::span<const Vector3> points, std::span<const Vector3> targets) {
    RigidMotion motion{.from = mean(points), .to = mean(targets)};
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < points.size(); ++k)
        covariance += (targets[k] - motion.to) * (points[k] - motion.from).transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Vector3 signs = Vector3::Ones();
    signs[2] = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0; // no reflection
    motion.rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
    return motion;
}

} // namespace livermark::experiments
