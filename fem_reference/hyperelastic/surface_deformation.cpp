#include "fem_reference/hyperelastic/surface_deformation.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::hyperelastic {

namespace {

using Vector3 = Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The matrix C_iJjL a_J b_L.
Matrix3 acoustic(const Tangent &tangent, const Vector3 &a, const Vector3 &b) {
    Matrix3 result = Matrix3::Zero();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                for (int l = 0; l < 3; ++l)
                    result(i, j) += tangent(3 * i + k, 3 * j + l) * a[k] * b[l];
    return result;
}

/// [S, H; -L, S^T] of Barnett and Lothe: the square root of -1 that has the invariant subspaces of a real matrix
/// without real eigenvalues, by Newton's method for the sign of a matrix.
/// @return not finite where there is none
Matrix6 root_of_minus_one(Matrix6 matrix) {
    constexpr int most_iterations = 40;
    constexpr double tolerance = 1e-11;
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
        const Matrix6 next = 0.5 * (matrix - matrix.inverse());
        const double change = (next - matrix).norm();
        matrix = next;
        if (!(change > tolerance * matrix.norm()))
            return matrix;
    }
    return Matrix6::Constant(std::numeric_limits<double>::quiet_NaN());
}

/// Impedance of waves along one direction, of moduli over their size.
double least_eigenvalue(const Tangent &tangent, const Vector3 &along, const Vector3 &inwards) {
    const Matrix3 q = acoustic(tangent, along, along), r = acoustic(tangent, along, inwards);
    const Matrix3 inverse = acoustic(tangent, inwards, inwards).inverse();
    Matrix6 stroh; // A. N. Stroh 1962, Steady state problems in anisotropic elasticity, J. Math. Phys. 41
    stroh << -inverse * r.transpose(), inverse, r * inverse * r.transpose() - q, -r * inverse;
    const Matrix6 root = root_of_minus_one(stroh);
    if (!root.allFinite())
        return std::numeric_limits<double>::quiet_NaN();
    const Matrix3 inverse_h = root.topRightCorner<3, 3>().inverse();
    Eigen::Matrix3cd impedance;
    impedance.real() = inverse_h;
    impedance.imag() = inverse_h * root.topLeftCorner<3, 3>();
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3cd>(impedance, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

} // namespace

Matrix3 whole_stress(const MaterialLaw &law, const core::Material &material, const Matrix3 &f) {
    const double jacobian = f.determinant();
    const auto volume = law.volume(jacobian);
    return law.stress(material, f) +
           law.volume_modulus(material) * volume.value * volume.slope * jacobian * f.inverse().transpose();
}

Tangent whole_tangent(const MaterialLaw &law, const core::Material &material, const Matrix3 &f) {
    const double jacobian = f.determinant(), modulus = law.volume_modulus(material);
    const auto volume = law.volume(jacobian);
    auto tangent = law.tangent(material, f);
    add_volume_tangent(modulus * volume.value * volume.slope,
                       modulus * (volume.slope * volume.slope + volume.value * volume.curvature), jacobian, f.inverse(),
                       tangent);
    return tangent;
}

void add_follower_pressure(double pressure, const Matrix3 &f, Tangent &tangent) {
    add_volume_tangent(pressure, 0.0, f.determinant(), f.inverse(), tangent);
}

double least_surface_impedance(const Tangent &tangent, const Vector3 &normal) {
    constexpr int num_directions = 12;
    const double size = tangent.diagonal().cwiseAbs().maxCoeff();
    const Vector3 first = normal.unitOrthogonal(), second = normal.cross(first);
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < num_directions; ++k) {
        const double angle = std::numbers::pi * k / num_directions; // -t has the conjugate impedance
        const double here =
            least_eigenvalue(tangent / size, std::cos(angle) * first + std::sin(angle) * second, -normal);
        if (!(here >= least))
            least = here;
        if (std::isnan(least))
            break;
    }
    return size * least;
}

namespace {

using core::Vector3;
using Face = std::array<int, 3>; ///< nodes of the elements, ascending

constexpr int num_corners = 4, num_nodes = 10;

/// F where three barycentric coordinates are 1/3 and that of one corner is 0.
/// @param cell  (10) corners, then midpoints of 01 12 20 03 13 23
Matrix3 deformation_opposite(int corner, std::span<const int> cell, const std::vector<Vector3> &points,
                             std::span<const double> displacement) {
    Matrix3 edges;
    for (int k = 0; k < 3; ++k)
        edges.col(k) = points[cell[k + 1]] - points[cell[0]];
    const Matrix3 inverse = edges.inverse();
    std::array<Vector3, num_corners> slope; // of barycentric coordinates
    slope[0].setZero();
    for (int k = 0; k < 3; ++k) {
        slope[k + 1] = inverse.row(k);
        slope[0] -= slope[k + 1];
    }
    const auto value = [&](int k) { return k == corner ? 0.0 : 1.0 / 3.0; };
    constexpr std::array<std::array<int, 2>, num_nodes - num_corners> ends{
        {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
    Matrix3 f = Matrix3::Identity();
    const auto add = [&](int node, const Vector3 &gradient) {
        f += Vector3::Map(&displacement[3 * static_cast<std::size_t>(cell[node])]) * gradient.transpose();
    };
    for (int k = 0; k < num_corners; ++k)
        add(k, (4.0 * value(k) - 1.0) * slope[k]);
    for (std::size_t e = 0; e < ends.size(); ++e) {
        const auto [a, b] = ends[e];
        add(num_corners + static_cast<int>(e), 4.0 * (value(a) * slope[b] + value(b) * slope[a]));
    }
    return f;
}

} // namespace

std::vector<SurfacePoint> surface_points(const Elements &elements, std::span<const double> displacement) {
    const auto &system = elements.system();
    const auto &mesh = elements.body().mesh;
    if (system.nodes_per_cell != num_nodes)
        throw std::invalid_argument("deformations of the surface are those of quadratic elements");
    std::map<Face, std::size_t> facet_of;
    for (std::size_t f = 0; f < mesh.boundary_triangles.size(); ++f) {
        Face face;
        std::ranges::transform(mesh.boundary_triangles[f], face.begin(),
                               [&](int node) { return system.mesh_node[node]; });
        facet_of[core::face_key(face)] = f;
    }
    std::vector<SurfacePoint> result(mesh.boundary_triangles.size());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        const auto cell = std::span(system.cell_nodes).subspan(t * num_nodes, num_nodes);
        for (int corner = 0; corner < num_corners; ++corner) {
            Face face;
            for (int k = 0, next = 0; k < num_corners; ++k)
                if (k != corner)
                    face[next++] = cell[k];
            face = core::face_key(face);
            const auto found = facet_of.find(face);
            if (found == facet_of.end())
                continue;
            auto &point = result[found->second];
            const Vector3 &a = system.points[face[0]], &b = system.points[face[1]], &c = system.points[face[2]];
            point.at_rest = (a + b + c) / 3.0;
            point.normal = (b - a).cross(c - a);
            point.area = 0.5 * point.normal.norm();
            point.normal /= 2.0 * point.area;
            if (point.normal.dot(system.points[cell[corner]] - a) > 0.0)
                point.normal = -point.normal;
            point.deformation = deformation_opposite(corner, cell, system.points, displacement);
            point.material = elements.body().materials[mesh.region[t]];
        }
    }
    return result;
}

Matrix3 under_traction(const MaterialLaw &law, const SurfacePoint &point, const Vector3 &traction) {
    const Vector3 &normal = point.normal, first = normal.unitOrthogonal(), second = normal.cross(first);
    const Vector3 spanned = (point.deformation * first).cross(point.deformation * second);
    const Matrix3 along = point.deformation - (point.deformation * normal) * normal.transpose();
    Vector3 across = spanned / spanned.squaredNorm(); // J = across . spanned = 1
    const auto with = [&](const Vector3 &column) { return Matrix3(along + column * normal.transpose()); };
    const auto out_of_balance = [&](const Vector3 &column) {
        return Vector3(whole_stress(law, point.material, with(column)) * normal - traction);
    };
    constexpr int most_iterations = 50;
    constexpr double tolerance = 1e-10, shortest = 1e-3;
    const double scale = point.material.shear_modulus();
    Vector3 residual = out_of_balance(across);
    for (int iteration = 0; iteration < most_iterations && residual.norm() > tolerance * scale; ++iteration) {
        const auto tangent = whole_tangent(law, point.material, with(across));
        Matrix3 slope = Matrix3::Zero();
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                slope(i, j) = normal.dot(tangent.block<3, 3>(3 * i, 3 * j) * normal);
        const Vector3 change = -slope.inverse() * residual;
        double part = 1.0;
        for (; part > shortest; part *= 0.5) {
            const Vector3 there = across + part * change;
            if (!(there.dot(spanned) > 0.0))
                continue;
            if (const Vector3 left = out_of_balance(there); left.norm() < residual.norm()) {
                across = there;
                residual = left;
                break;
            }
        }
        if (!(part > shortest))
            break;
    }
    if (!(residual.norm() <= tolerance * scale))
        return Matrix3::Constant(std::numeric_limits<double>::quiet_NaN());
    return with(across);
}

double unstable_part(const Elements &elements, const core::LoadCase &load_case, std::span<const double> displacement,
                     double factor) {
    const auto &law = elements.law();
    const auto surface = surface_points(elements, displacement);
    double unstable = 0.0, loaded = 0.0;
    for (int f = 0; f < load_case.num_facets(); ++f) {
        if (!load_case.is_loaded(f) || load_case.follows_surface(f))
            continue;
        const auto &point = surface[f];
        loaded += point.area;
        const Vector3 traction = load_case.value[f].array().isNaN().select(0.0, factor * load_case.value[f].array());
        const auto deformation = under_traction(law, point, traction);
        const bool is_stable =
            deformation.allFinite() &&
            least_surface_impedance(whole_tangent(law, point.material, deformation), point.normal) > 0.0;
        unstable += is_stable ? 0.0 : point.area;
    }
    return loaded > 0.0 ? unstable / loaded : 0.0;
}

SurfaceStretches surface_stretches(const SurfacePoint &point) {
    Eigen::Matrix<double, 3, 2> along;
    along.col(0) = point.normal.unitOrthogonal();
    along.col(1) = point.normal.cross(along.col(0));
    const Eigen::Matrix<double, 3, 2> stretched = point.deformation * along;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> squares(stretched.transpose() * stretched,
                                                                 Eigen::EigenvaluesOnly);
    return {std::sqrt(squares.eigenvalues()[0]), std::sqrt(squares.eigenvalues()[1])};
}

} // namespace livermark::hyperelastic
