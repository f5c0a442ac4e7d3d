#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"
#include "msm/springs/springs.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

namespace {

/// Symmetric 2 x 2 tensors in the orthonormal components 11, 22 and sqrt 2 times 12.
using Plane3 = Eigen::Vector3d;

Plane3 plane_components(const Eigen::Matrix2d &of) {
    return {of(0, 0), of(1, 1), std::numbers::sqrt2 * 0.5 * (of(0, 1) + of(1, 0))};
}

Eigen::Matrix2d plane_tensor(const Plane3 &of) {
    Eigen::Matrix2d result;
    result << of[0], of[2] / std::numbers::sqrt2, of[2] / std::numbers::sqrt2, of[1];
    return result;
}

/// The matrix of X -> A X A in these components.
Eigen::Matrix3d both_sides(const Eigen::Matrix2d &a) {
    Eigen::Matrix3d result;
    for (int k = 0; k < 3; ++k)
        result.col(k) = plane_components(a * plane_tensor(Plane3::Unit(k)) * a);
    return result;
}

constexpr std::array<std::array<std::size_t, 2>, 3> edges_of_facet{{{0, 1}, {1, 2}, {2, 0}}};

/// Facet that the capsule covers.
struct CoveredFacet {
    OuterFace face;
    std::array<int, 3> nodes;
    Eigen::Vector3d rest_square;      ///< l0^2 of its edges [m^2]
    Eigen::Matrix3d strain_of_square; ///< D: E = D (l^2 - l0^2), a column for each edge [1/m^2]
    double area;                      ///< at rest [m^2]
};

using Spans = std::array<core::Vector3, 3>;

Spans facet_spans(const CoveredFacet &facet, const Eigen::VectorXd &field) {
    Spans spans;
    for (std::size_t e = 0; e < 3; ++e)
        spans[e] =
            node_part(field, facet.nodes[edges_of_facet[e][1]]) - node_part(field, facet.nodes[edges_of_facet[e][0]]);
    return spans;
}

/// E = -1/4 sum over edges ij of (l^2 - l0^2)_ij (g_i g_j^T + g_j g_i^T), with g the gradients of the barycentric
/// coordinates in the plane (Delingette 2008, IEEE TVCG 14(2)).
CoveredFacet covered_facet(const core::TetraMesh &mesh, const OuterFace &face) {
    const int f = face.facet;
    CoveredFacet facet{.face = face,
                       .nodes = mesh.boundary_triangles[f],
                       .rest_square = {},
                       .strain_of_square = {},
                       .area = core::area_vector(mesh, f).norm()};
    const auto &[a, b, c] = facet.nodes;
    const core::Vector3 first = mesh.points[b] - mesh.points[a], second = mesh.points[c] - mesh.points[a];
    const core::Vector3 along = first.normalized(), across = core::area_vector(mesh, f).normalized().cross(along);
    Eigen::Matrix2d edges;
    edges << first.dot(along), second.dot(along), first.dot(across), second.dot(across);
    const Eigen::Matrix2d inverse = edges.inverse(); // rows are the gradients at b and c
    const std::array<Eigen::Vector2d, 3> gradient{-(inverse.row(0) + inverse.row(1)).transpose(),
                                                  inverse.row(0).transpose(), inverse.row(1).transpose()};
    for (std::size_t e = 0; e < 3; ++e) {
        const auto [i, j] = edges_of_facet[e];
        facet.rest_square[static_cast<Eigen::Index>(e)] =
            (mesh.points[facet.nodes[j]] - mesh.points[facet.nodes[i]]).squaredNorm();
        const Eigen::Matrix2d both = gradient[i] * gradient[j].transpose();
        facet.strain_of_square.col(static_cast<Eigen::Index>(e)) = plane_components(-0.25 * (both + both.transpose()));
    }
    return facet;
}

class CoupledCapsule : public ElasticTerm {
  public:
    explicit CoupledCapsule(const core::Body &body)
        : modulus_(body.capsule->stiffness() / 3.0), rest_(to_unknowns(body.mesh.points)) {
        for (const auto &face : covered_faces(body))
            facets_.push_back(covered_facet(body.mesh, face));
    }

    double energy(const Eigen::VectorXd &x) const override {
        double sum = 0.0;
        for (const auto &facet : facets_) {
            // tr C + 1 / det C - 3 without the digits that are the same: C = I + 2 E, det C = 1 + d
            const Eigen::Matrix2d e = strain(facet, facet_spans(facet, x));
            const double d = 2.0 * e.trace() + 4.0 * e.determinant();
            sum += 0.5 * modulus_ * facet.area * (d * d / (1.0 + d) - 4.0 * e.determinant());
        }
        return sum;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        for (const auto &facet : facets_) {
            const auto spans = facet_spans(facet, x);
            Plane3 stress = stress_of(cauchy_green(facet, spans));
            if (beta != 0.0) {
                const auto rates = facet_spans(facet, v);
                Eigen::Vector3d square_rate;
                for (std::size_t e = 0; e < 3; ++e)
                    square_rate[static_cast<Eigen::Index>(e)] = 2.0 * spans[e].dot(rates[e]);
                stress += beta * (stiffness_at_rest() * (facet.strain_of_square * square_rate));
            }
            const Eigen::Vector3d tension = tensions(facet, stress);
            for (std::size_t e = 0; e < 3; ++e) {
                const core::Vector3 pull = 2.0 * tension[static_cast<Eigen::Index>(e)] * spans[e];
                node_part(force, facet.nodes[edges_of_facet[e][0]]) += pull;
                node_part(force, facet.nodes[edges_of_facet[e][1]]) -= pull;
            }
        }
    }

    /// @param x  empty for the body at rest
    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(81 * facets_.size());
        for (const auto &facet : facets_) {
            const Matrix9 block = block_of(facet, x.size() == 0 ? rest_ : x, tangent);
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t b = 0; b < 3; ++b)
                    for (int i = 0; i < 3; ++i)
                        for (int j = 0; j < 3; ++j)
                            entries.emplace_back(
                                3 * facet.nodes[a] + i, 3 * facet.nodes[b] + j,
                                block(static_cast<Eigen::Index>(3 * a) + i, static_cast<Eigen::Index>(3 * b) + j));
        }
        return square_matrix(entries, rest_.size());
    }

    /// Three times the blocks of the nodes of a facet: u^T K u <= n sum u_i^T K_ii u_i for K of n nodes.
    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        for (const auto &facet : facets_) {
            const Matrix9 block = block_of(facet, x, Tangent::material);
            for (std::size_t a = 0; a < 3; ++a)
                blocks[static_cast<std::size_t>(facet.nodes[a])] +=
                    3.0 * block.block<3, 3>(static_cast<Eigen::Index>(3 * a), static_cast<Eigen::Index>(3 * a));
        }
    }

    bool is_beside_kernels() const override { return true; }

    /// A facet goes with its tetrahedron, or gets the nodes of it; what a cut opens is not covered.
    std::shared_ptr<const ElasticTerm> after_cut(const CutTetrahedra &left) const override {
        auto term = std::make_shared<CoupledCapsule>(*this);
        term->rest_ = left.rest;
        take_cut(term->facets_, left);
        return term;
    }

  private:
    using Matrix9 = Eigen::Matrix<double, 9, 9>;

    static Eigen::Matrix2d strain(const CoveredFacet &facet, const Spans &spans) {
        Eigen::Vector3d gain = -facet.rest_square;
        for (std::size_t e = 0; e < 3; ++e)
            gain[static_cast<Eigen::Index>(e)] += spans[e].squaredNorm();
        return plane_tensor(facet.strain_of_square * gain);
    }

    static Eigen::Matrix2d cauchy_green(const CoveredFacet &facet, const Spans &spans) {
        return Eigen::Matrix2d::Identity() + 2.0 * strain(facet, spans);
    }

    /// S = 2 dW/dC = E t / 3 (I - C^-1 / det C) [N/m]
    Plane3 stress_of(const Eigen::Matrix2d &c) const {
        return modulus_ * plane_components(Eigen::Matrix2d::Identity() - c.inverse() / c.determinant());
    }

    /// dS/dE = 2 dS/dC [N/m]
    Eigen::Matrix3d stiffness_of(const Eigen::Matrix2d &c) const {
        const Eigen::Matrix2d inverse = c.inverse();
        const Plane3 along = plane_components(inverse);
        return 2.0 * modulus_ / c.determinant() * (along * along.transpose() + both_sides(inverse));
    }

    Eigen::Matrix3d stiffness_at_rest() const { return stiffness_of(Eigen::Matrix2d::Identity()); }

    /// dW/d(l^2) of the edges of a facet [N/m]
    static Eigen::Vector3d tensions(const CoveredFacet &facet, const Plane3 &stress) {
        return facet.area * (facet.strain_of_square.transpose() * stress);
    }

    Matrix9 block_of(const CoveredFacet &facet, const Eigen::VectorXd &x, Tangent tangent) const {
        const auto spans = facet_spans(facet, x);
        const Eigen::Matrix2d c = cauchy_green(facet, spans);
        Eigen::Matrix<double, 9, 3> slope = Eigen::Matrix<double, 9, 3>::Zero(); // d(l^2)/dx
        for (std::size_t e = 0; e < 3; ++e) {
            const auto [i, j] = edges_of_facet[e];
            slope.block<3, 1>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(e)) = -2.0 * spans[e];
            slope.block<3, 1>(static_cast<Eigen::Index>(3 * j), static_cast<Eigen::Index>(e)) = 2.0 * spans[e];
        }
        const Eigen::Matrix3d stiffness = tangent == Tangent::material ? stiffness_at_rest() : stiffness_of(c);
        Matrix9 block = facet.area * slope * facet.strain_of_square.transpose() * stiffness * facet.strain_of_square *
                        slope.transpose();
        if (tangent == Tangent::material)
            return block;
        Plane3 stress = stress_of(c);
        if (tangent == Tangent::semi_definite)
            stress = pulling(stress);
        const Eigen::Vector3d tension = tensions(facet, stress);
        for (std::size_t e = 0; e < 3; ++e) {
            const auto [i, j] = edges_of_facet[e];
            const Eigen::Matrix3d turn = 2.0 * tension[static_cast<Eigen::Index>(e)] * Eigen::Matrix3d::Identity();
            const auto at = [&block](std::size_t a, std::size_t b) {
                return block.block<3, 3>(static_cast<Eigen::Index>(3 * a), static_cast<Eigen::Index>(3 * b));
            };
            at(i, i) += turn;
            at(j, j) += turn;
            at(i, j) -= turn;
            at(j, i) -= turn;
        }
        return block;
    }

    /// A stress without its compression.
    static Plane3 pulling(const Plane3 &stress) {
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> principal(plane_tensor(stress));
        return plane_components(principal.eigenvectors() * principal.eigenvalues().cwiseMax(0.0).asDiagonal() *
                                principal.eigenvectors().transpose());
    }

    double modulus_; // E t / 3 [N/m]
    Eigen::VectorXd rest_;
    std::vector<CoveredFacet> facets_;
};

} // namespace

std::vector<OuterFace> outer_faces_of(const core::TetraMesh &mesh, std::span<const int> facets) {
    std::vector<OuterFace> outer;
    const auto faces = core::sorted_faces(mesh.tetrahedra);
    for (const int f : facets) {
        const auto &triangle = mesh.boundary_triangles[f];
        const auto key = core::face_key(triangle);
        const auto found = std::ranges::lower_bound(faces, key, {}, &core::TetrahedronFace::nodes);
        if (found == faces.end() || found->nodes != key)
            throw support::InputError("triangle {} of the surface is no face of a tetrahedron; make the mesh again", f);
        auto &face = outer.emplace_back(OuterFace{.tetrahedron = found->tetrahedron, .corners = {}, .facet = f});
        const auto &nodes = mesh.tetrahedra[static_cast<std::size_t>(found->tetrahedron)];
        std::ranges::transform(triangle, face.corners.begin(), [&](int node) {
            return static_cast<int>(std::ranges::find(nodes, node) - nodes.begin());
        });
    }
    return outer;
}

std::vector<OuterFace> covered_faces(const core::Body &body) {
    std::vector<int> covered;
    if (body.capsule)
        for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
            if (core::Capsule::covers(body.mesh, f))
                covered.push_back(f);
    return covered.empty() ? std::vector<OuterFace>{} : outer_faces_of(body.mesh, covered);
}

std::shared_ptr<const ElasticTerm> coupled_capsule(const core::Body &body) {
    return body.capsule ? std::make_shared<const CoupledCapsule>(body) : nullptr;
}

} // namespace livermark::msm
