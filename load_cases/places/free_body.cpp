#include "load_cases/places/free_body.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <vector>

#include "load_cases/places/selector.hpp"

namespace livermark::load_cases {

namespace {

using core::Vector3;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Of the largest eigenvalue: what is constrained at one facet of a large patch is far above, rounding far below.
constexpr double rounding_of_balance = 1e-12;

/// Which components of which nodes are constrained.
std::vector<std::array<bool, 3>> constrained_components(const core::TetraMesh &mesh, const core::LoadCase &load_case) {
    std::vector<std::array<bool, 3>> constrained(mesh.points.size(), {false, false, false});
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_constrained(f))
            for (const int node : mesh.boundary_triangles[f])
                for (int i = 0; i < 3; ++i)
                    if (!std::isnan(load_case.value[f][i]))
                        constrained[node][i] = true;
    return constrained;
}

std::string name_of_axis(const Vector3 &direction) {
    int axis = 0;
    const double largest = direction.cwiseAbs().maxCoeff(&axis);
    return largest > 0.999 * direction.norm()
               ? std::string(1, "xyz"[axis])
               : fmt::format("({:.2g}, {:.2g}, {:.2g})", direction.x(), direction.y(), direction.z());
}

} // namespace

void refuse_free_body(const core::TetraMesh &mesh, const core::LoadCase &load_case, const std::string &file) {
    const auto constrained = constrained_components(mesh, load_case);
    Vector3 centroid = Vector3::Zero();
    double num_constrained = 0.0;
    for (std::size_t n = 0; n < constrained.size(); ++n)
        for (const bool component : constrained[n])
            if (component) {
                centroid += mesh.points[n];
                ++num_constrained;
            }
    centroid /= num_constrained;
    double square = 0.0;
    for (std::size_t n = 0; n < constrained.size(); ++n)
        for (const bool component : constrained[n])
            square += component ? (mesh.points[n] - centroid).squaredNorm() : 0.0;
    const double radius = std::sqrt(square / num_constrained);
    Matrix6 gram = Matrix6::Zero();
    for (std::size_t n = 0; n < constrained.size(); ++n)
        for (int i = 0; i < 3; ++i)
            if (constrained[n][i]) {
                Vector6 row;
                row << Vector3::Unit(i), (mesh.points[n] - centroid).cross(Vector3::Unit(i)) / radius;
                gram += row * row.transpose();
            }
    const Eigen::SelfAdjointEigenSolver<Matrix6> motions(gram);
    if (motions.eigenvalues()[0] > rounding_of_balance * motions.eigenvalues()[5])
        return;
    // Of several free motions the solver may mix slides and turns; a slide is the easier one to say and to hold.
    for (int i = 0; i < 3; ++i)
        if (std::ranges::none_of(constrained, [=](const auto &components) { return components[i]; }))
            throw NotOnBody(
                file, fmt::format("the body as a whole can still slide along {}", "xyz"[i]),
                fmt::format("add a [[condition]] with a displacement that is not \"free\" in {}", "xyz"[i]));
    const Vector3 axis = motions.eigenvectors().col(0).tail<3>();
    throw NotOnBody(file, fmt::format("the body as a whole can still turn about {}", name_of_axis(axis)),
                    "add a [[condition]] with a displacement that prevents it");
}

} // namespace livermark::load_cases
