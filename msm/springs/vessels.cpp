#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "core/mesh/places.hpp"
#include "msm/springs/springs.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

namespace {

/// The vessels of a body in its tetrahedra, whose corners they move with: at a point of a tube of the direction d at
/// rest, F d = sum over the corners of x_a (grad l_a . d) with the barycentric coordinates l_a.
class VesselLines : public ElasticTerm {
  public:
    explicit VesselLines(const core::Body &body)
        : rest_(to_unknowns(body.mesh.points)), points_(core::vessel_points(body)) {
        for (const auto &point : points_) {
            const auto &nodes = body.mesh.tetrahedra[static_cast<std::size_t>(point.tetrahedron)];
            nodes_.push_back(nodes);
            slope_.push_back(core::coordinate_slopes(body.mesh, nodes, point.direction));
        }
    }

    double energy(const Eigen::VectorXd &x) const override {
        double energy = 0.0;
        for (std::size_t p = 0; p < points_.size(); ++p)
            energy += points_[p].energy(along(x, p));
        return energy;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        for (std::size_t p = 0; p < points_.size(); ++p) {
            const core::Vector3 axis = along(x, p);
            core::Vector3 pull = points_[p].pull(axis);
            if (beta != 0.0) {
                const core::Vector3 direction = axis.normalized();
                pull += beta * points_[p].weight * direction.dot(along(v, p)) * direction;
            }
            for (int a = 0; a < 4; ++a)
                node_part(force, nodes_[p][static_cast<std::size_t>(a)]) -= slope_[p][a] * pull;
        }
    }

    /// @param x  empty for the body at rest
    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        const auto &positions = x.size() == 0 ? rest_ : x;
        return sum_of_blocks(nodes_, rest_.size(), [&](std::size_t p) {
            const auto block = stiffness_of(positions, p, tangent);
            Matrix12 local;
            for (int a = 0; a < 4; ++a)
                for (int b = 0; b < 4; ++b)
                    local.block<3, 3>(3 * a, 3 * b) = slope_[p][a] * slope_[p][b] * block;
            return local;
        });
    }

    /// Four times the blocks of the corners: u^T K u <= n sum u_i^T K_ii u_i for K of n nodes.
    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        for (std::size_t p = 0; p < points_.size(); ++p) {
            const auto block = stiffness_of(x, p, Tangent::material);
            for (int a = 0; a < 4; ++a)
                blocks[static_cast<std::size_t>(nodes_[p][static_cast<std::size_t>(a)])] +=
                    4.0 * slope_[p][a] * slope_[p][a] * block;
        }
    }

    bool is_beside_kernels() const override { return true; }

    /// The part of a fibre in a tetrahedron goes with it. Where a cut parts two tetrahedra a fibre ends in each of
    /// them: none of its points moves with the nodes of more than one.
    std::shared_ptr<const ElasticTerm> after_cut(const CutTetrahedra &left) const override {
        auto term = std::make_shared<VesselLines>(*this);
        term->rest_ = left.rest;
        term->points_.clear();
        term->nodes_.clear();
        term->slope_.clear();
        for (std::size_t p = 0; p < points_.size(); ++p) {
            const auto t = static_cast<std::size_t>(points_[p].tetrahedron);
            if (left.is_removed[t] != 0)
                continue;
            term->points_.push_back(points_[p]);
            term->nodes_.push_back(left.nodes[t]);
            term->slope_.push_back(slope_[p]);
        }
        return term;
    }

  private:
    /// F d, or its rate.
    core::Vector3 along(const Eigen::VectorXd &x, std::size_t p) const {
        core::Vector3 result = core::Vector3::Zero();
        for (int a = 0; a < 4; ++a)
            result += slope_[p][a] * node_part(x, nodes_[p][static_cast<std::size_t>(a)]);
        return result;
    }

    Eigen::Matrix3d stiffness_of(const Eigen::VectorXd &x, std::size_t p, Tangent tangent) const {
        const core::Vector3 axis = along(x, p);
        const bool is_pressed = axis.squaredNorm() < 1.0;
        if (tangent == Tangent::material || (tangent == Tangent::semi_definite && is_pressed)) {
            const core::Vector3 direction = axis.normalized();
            return points_[p].weight * direction * direction.transpose();
        }
        return points_[p].stiffness(axis);
    }

    Eigen::VectorXd rest_; // (3N) [m]
    std::vector<core::VesselPoint> points_;
    std::vector<std::array<int, 4>> nodes_; // of the tetrahedron of each point
    std::vector<Eigen::Vector4d> slope_;    // grad l_a . d [1/m]
};

} // namespace

std::shared_ptr<const ElasticTerm> vessel_lines(const core::Body &body) {
    return body.vessels ? std::make_shared<const VesselLines>(body) : nullptr;
}

ElasticBody with_vessel_lines(ElasticBody tissue, const core::Body &body) {
    if (const auto vessels = vessel_lines(body))
        tissue.add(vessels);
    return tissue;
}

} // namespace livermark::msm
