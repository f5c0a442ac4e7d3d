#include "fem_reference/linear/facets.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_simplex_p.h>
#include <numeric>
#include <utility>

#include "fem_reference/solvers/matrices.hpp"

namespace livermark::fem_reference {

using core::Vector3;

ReferenceTriangle reference_triangle(int degree) {
    const dealii::FE_SimplexP<2> element(degree);
    const dealii::QWitherdenVincentSimplex<2> quadrature(3);
    ReferenceTriangle result;
    for (unsigned int q = 0; q < quadrature.size(); ++q) {
        const auto &point = quadrature.point(q);
        result.weight.push_back(quadrature.weight(q));
        auto &shape = result.shape.emplace_back(element.n_dofs_per_cell());
        auto &gradient = result.gradient.emplace_back(2, element.n_dofs_per_cell());
        for (unsigned int a = 0; a < element.n_dofs_per_cell(); ++a) {
            shape[a] = element.shape_value(a, point);
            for (int d = 0; d < 2; ++d)
                gradient(d, a) = element.shape_grad(a, point)[d];
        }
    }
    return result;
}

std::vector<int> nodes_of_facet(const ElasticSystem &system, const core::TetraMesh &mesh, std::size_t facet) {
    std::vector<int> nodes;
    for (const int corner : mesh.boundary_triangles[facet])
        nodes.push_back(system.mesh_node[corner]);
    const auto there =
        std::span(system.facet_nodes).subspan(facet * system.nodes_per_facet, system.nodes_per_facet).subspan(3);
    for (std::size_t k = 0; k < there.size(); ++k) {
        const Vector3 middle = 0.5 * (system.points[nodes[k]] + system.points[nodes[(k + 1) % 3]]);
        nodes.push_back(*std::ranges::min_element(
            there, {}, [&](int node) { return (system.points[node] - middle).squaredNorm(); }));
    }
    return nodes;
}

void add_to(SymmetricBlocks<double> &stiffness, std::span<const int> nodes, const Eigen::MatrixXd &matrix) {
    const auto &rows = stiffness.rows;
    for (std::size_t a = 0; a < nodes.size(); ++a)
        for (std::size_t b = 0; b < nodes.size(); ++b) {
            if (nodes[b] > nodes[a])
                continue;
            auto &block = a == b ? stiffness.diagonal[nodes[a]]
                                 : stiffness.below[place_of_entry(rows.row_start, rows.column, nodes[a], nodes[b])];
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    block[3 * i + j] +=
                        matrix(static_cast<Eigen::Index>(3 * a) + i, static_cast<Eigen::Index>(3 * b) + j);
        }
}

Membrane::Membrane(const core::Body &body, const ElasticSystem &system) {
    if (!body.capsule)
        return;
    modulus_ = body.capsule->stiffness() / 3.0;
    reference_ = reference_triangle(system.nodes_per_cell == 4 ? 1 : 2);
    const auto surface = core::capsule_surface(body);
    const auto faces = core::sorted_faces(body.mesh.tetrahedra);
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f) {
        if (!core::Capsule::covers(body.mesh, f))
            continue;
        const auto &corners = body.mesh.boundary_triangles[f];
        const auto face = std::ranges::lower_bound(faces, core::face_key(corners), {}, &core::TetrahedronFace::nodes);
        Facet facet{.nodes = nodes_of_facet(system, body.mesh, static_cast<std::size_t>(f)),
                    .tetrahedron = face->tetrahedron,
                    .rest = {}};
        facet.rest.resize(3, static_cast<Eigen::Index>(facet.nodes.size()));
        for (std::size_t a = 0; a < facet.nodes.size(); ++a) {
            const int first = corners[a % 3], second = corners[(a + 1) % 3]; // of the edge of a midpoint
            facet.rest.col(static_cast<Eigen::Index>(a)) =
                system.points[facet.nodes[a]] +
                (a < 3 ? surface->offset[first] : surface->offset_between(body.mesh, first, second));
        }
        facets_.push_back(std::move(facet));
    }
}

/// A point of integration of a facet.
struct Membrane::Point {
    Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, 6> gradients; ///< of the nodes, in its plane [1/m]
    double weight;                                                             ///< area times E t / 3 [N m]
    Eigen::Matrix<double, 3, 2> f;
    Eigen::Matrix2d inverse; ///< C^-1
    double squeeze;          ///< 1 / det C
    /// W over E t / 6: tr C + 1 / det C - 3 without the digits that are the same, C = I + 2 E and det C = 1 + d
    double energy;

    /// 2 dW/dC over E t / 3
    Eigen::Matrix2d stress() const { return Eigen::Matrix2d::Identity() - squeeze * inverse; }
};

Membrane::Point Membrane::at_point(const Facet &facet, std::size_t q, std::span<const double> displacement) const {
    const Eigen::Matrix<double, 3, 2> tangents = facet.rest * reference_.gradient[q].transpose();
    Eigen::Matrix<double, 3, 2> plane; // orthonormal
    plane.col(0) = tangents.col(0).normalized();
    const Vector3 area = tangents.col(0).cross(tangents.col(1));
    plane.col(1) = area.normalized().cross(plane.col(0));
    Point point;
    point.weight = reference_.weight[q] * area.norm() * modulus_;
    point.gradients = (plane.transpose() * tangents).inverse().transpose() * reference_.gradient[q];
    Eigen::Matrix<double, 3, 2> moved = Eigen::Matrix<double, 3, 2>::Zero(); // F less that at rest
    if (!displacement.empty())
        for (std::size_t a = 0; a < facet.nodes.size(); ++a)
            moved += Vector3::Map(&displacement[3 * facet.nodes[a]]) *
                     point.gradients.col(static_cast<Eigen::Index>(a)).transpose();
    point.f = plane + moved;
    const Eigen::Matrix2d turned = plane.transpose() * moved;
    const Eigen::Matrix2d strain = 0.5 * (turned + turned.transpose() + moved.transpose() * moved);
    const double d = 2.0 * strain.trace() + 4.0 * strain.determinant();
    point.inverse = (Eigen::Matrix2d::Identity() + 2.0 * strain).inverse();
    point.squeeze = 1.0 / (1.0 + d);
    point.energy = d * d / (1.0 + d) - 4.0 * strain.determinant();
    return point;
}

double Membrane::add_force(std::span<const double> displacement, std::span<double> force,
                           std::span<const double> energy_share) const {
    double energy = 0.0;
    for (const auto &facet : facets_) {
        const double share = energy_share.empty() ? 1.0 : energy_share[static_cast<std::size_t>(facet.tetrahedron)];
        for (std::size_t q = 0; q < reference_.weight.size(); ++q) {
            const auto point = at_point(facet, q, displacement);
            energy += share * 0.5 * point.weight * point.energy;
            const Eigen::Matrix<double, 3, 2> pull = point.weight * point.f * point.stress();
            for (std::size_t a = 0; a < facet.nodes.size(); ++a)
                Vector3::Map(&force[3 * facet.nodes[a]]) += pull * point.gradients.col(static_cast<Eigen::Index>(a));
        }
    }
    return energy;
}

void Membrane::add_stiffness(std::span<const double> displacement, SymmetricBlocks<double> &stiffness) const {
    for (const auto &facet : facets_) {
        const auto num_nodes = static_cast<Eigen::Index>(facet.nodes.size());
        Eigen::MatrixXd local = Eigen::MatrixXd::Zero(3 * num_nodes, 3 * num_nodes);
        for (std::size_t q = 0; q < reference_.weight.size(); ++q) {
            const auto point = at_point(facet, q, displacement);
            const Eigen::Matrix2d stress = point.stress();
            const Eigen::Matrix<double, 3, 2> turned = point.f * point.inverse;
            const Eigen::Matrix3d projector = turned * point.f.transpose();
            for (Eigen::Index a = 0; a < num_nodes; ++a)
                for (Eigen::Index b = 0; b < num_nodes; ++b) {
                    const Eigen::Vector2d at_a = point.gradients.col(a), at_b = point.gradients.col(b);
                    const Vector3 pull_a = turned * at_a, pull_b = turned * at_b;
                    local.block<3, 3>(3 * a, 3 * b) +=
                        point.weight *
                        (at_a.dot(stress * at_b) * Eigen::Matrix3d::Identity() +
                         point.squeeze * (2.0 * pull_a * pull_b.transpose() + pull_b * pull_a.transpose() +
                                          at_a.dot(point.inverse * at_b) * projector));
                }
        }
        add_to(stiffness, facet.nodes, local);
    }
}

FoundationSprings::FoundationSprings(const std::optional<core::Foundation> &foundation, const core::TetraMesh &mesh,
                                     const ElasticSystem &system) {
    if (!foundation)
        return;
    const auto reference = reference_triangle(system.nodes_per_cell == 4 ? 1 : 2);
    constexpr double area_of_unit_triangle = 0.5;
    for (std::size_t which = 0; which < foundation->facets.size(); ++which) {
        const int f = foundation->facets[which];
        Facet facet{.nodes = nodes_of_facet(system, mesh, static_cast<std::size_t>(f)), .stiffness = {}};
        const auto num_nodes = static_cast<Eigen::Index>(facet.nodes.size());
        Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(num_nodes, num_nodes); // integral of N_a N_b
        for (std::size_t q = 0; q < reference.weight.size(); ++q)
            mass += reference.weight[q] / area_of_unit_triangle * reference.shape[q] * reference.shape[q].transpose();
        mass *= core::area_vector(mesh, f).norm();
        const Eigen::Matrix3d per_area = foundation->stiffness_on(mesh, which);
        facet.stiffness.resize(3 * num_nodes, 3 * num_nodes);
        for (Eigen::Index a = 0; a < num_nodes; ++a)
            for (Eigen::Index b = 0; b < num_nodes; ++b)
                facet.stiffness.block<3, 3>(3 * a, 3 * b) = mass(a, b) * per_area;
        facets_.push_back(std::move(facet));
    }
}

void FoundationSprings::add_force(std::span<const double> displacement, std::span<double> force) const {
    for (const auto &[nodes, stiffness] : facets_)
        for (std::size_t a = 0; a < nodes.size(); ++a)
            for (std::size_t b = 0; b < nodes.size(); ++b)
                Vector3::Map(&force[3 * nodes[a]]) +=
                    stiffness.block<3, 3>(static_cast<Eigen::Index>(3 * a), static_cast<Eigen::Index>(3 * b)) *
                    Vector3::Map(&displacement[3 * nodes[b]]);
}

double FoundationSprings::energy(std::span<const double> displacement) const {
    std::vector<double> force(displacement.size(), 0.0);
    add_force(displacement, force);
    return 0.5 * std::inner_product(force.begin(), force.end(), displacement.begin(), 0.0);
}

void FoundationSprings::add_stiffness(SymmetricBlocks<double> &stiffness) const {
    for (const auto &facet : facets_)
        add_to(stiffness, facet.nodes, facet.stiffness);
}

} // namespace livermark::fem_reference
