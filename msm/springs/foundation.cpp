#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <vector>

#include "core/events.hpp"
#include "core/part_springs.hpp"
#include "msm/springs/springs.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

namespace {

/// Facet that stands on springs.
struct StandingFacet {
    OuterFace face;
    std::array<int, 3> nodes;
    Eigen::Matrix3d stiffness; ///< B: the blocks K_ab are (1 + delta_ab) B, as core::foundation_stiffness() [N/m]
};

class FoundationSprings : public ElasticTerm {
  public:
    FoundationSprings(const core::TetraMesh &mesh, const core::Foundation &foundation)
        : rest_(to_unknowns(mesh.points)) {
        const auto faces = outer_faces_of(mesh, foundation.facets);
        for (std::size_t i = 0; i < faces.size(); ++i) {
            const int facet = faces[i].facet;
            facets_.push_back(
                {.face = faces[i],
                 .nodes = mesh.boundary_triangles[facet],
                 .stiffness = core::area_vector(mesh, facet).norm() / 12.0 * foundation.stiffness_on(mesh, i)});
        }
    }

    double energy(const Eigen::VectorXd &x) const override {
        double sum = 0.0;
        for (const auto &facet : facets_) {
            const auto u = displacements(facet, x);
            const auto pull = pulls(facet, u);
            for (std::size_t a = 0; a < 3; ++a)
                sum += 0.5 * u[a].dot(pull[a]);
        }
        return sum;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        for (const auto &facet : facets_) {
            auto u = displacements(facet, x);
            if (beta != 0.0)
                for (std::size_t a = 0; a < 3; ++a)
                    u[a] += beta * node_part(v, facet.nodes[a]);
            const auto pull = pulls(facet, u);
            for (std::size_t a = 0; a < 3; ++a)
                node_part(force, facet.nodes[a]) -= pull[a];
        }
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd & /*x*/, Tangent /*tangent*/) const override {
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(81 * facets_.size());
        for (const auto &facet : facets_)
            core::add_blocks(entries, facet.nodes, core::linear_shares, facet.stiffness);
        return square_matrix(entries, rest_.size());
    }

    void add_hessian_product(const Eigen::VectorXd & /*x*/, const Eigen::VectorXd &u,
                             Eigen::VectorXd &product) const override {
        for (const auto &facet : facets_) {
            const auto pull = pulls(
                facet, {node_part(u, facet.nodes[0]), node_part(u, facet.nodes[1]), node_part(u, facet.nodes[2])});
            for (std::size_t a = 0; a < 3; ++a)
                node_part(product, facet.nodes[a]) += pull[a];
        }
    }

    /// The sum of each row of blocks, which are positive semi-definite: 2 u . B v is at most u . B u + v . B v.
    void add_block_bound(const Eigen::VectorXd & /*x*/, std::vector<Eigen::Matrix3d> &blocks) const override {
        for (const auto &facet : facets_)
            for (const int node : facet.nodes)
                blocks[static_cast<std::size_t>(node)] += 4.0 * facet.stiffness;
    }

    bool is_beside_kernels() const override { return true; }

    /// A facet goes with its tetrahedron, or gets the nodes of it; what a cut opens stands on nothing.
    std::shared_ptr<const ElasticTerm> after_cut(const CutTetrahedra &left) const override {
        auto term = std::make_shared<FoundationSprings>(*this);
        term->rest_ = left.rest;
        take_cut(term->facets_, left);
        return term;
    }

  private:
    using OfCorners = std::array<core::Vector3, 3>;

    OfCorners displacements(const StandingFacet &facet, const Eigen::VectorXd &x) const {
        OfCorners u;
        for (std::size_t a = 0; a < 3; ++a)
            u[a] = node_part(x, facet.nodes[a]) - node_part(rest_, facet.nodes[a]);
        return u;
    }

    /// K u
    static OfCorners pulls(const StandingFacet &facet, const OfCorners &u) {
        const core::Vector3 sum = u[0] + u[1] + u[2];
        OfCorners pull;
        for (std::size_t a = 0; a < 3; ++a)
            pull[a] = facet.stiffness * (u[a] + sum);
        return pull;
    }

    Eigen::VectorXd rest_; // (3N) X [m]
    std::vector<StandingFacet> facets_;
};

} // namespace

std::shared_ptr<const ElasticTerm> foundation_springs(const core::TetraMesh &mesh, const core::Foundation &foundation) {
    return std::make_shared<const FoundationSprings>(mesh, foundation);
}

} // namespace livermark::msm
