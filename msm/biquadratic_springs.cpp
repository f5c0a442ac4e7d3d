#include "msm/biquadratic_springs.hpp"

#include <algorithm>

#include "msm/tetrahedron_volume.hpp"

namespace livermark::msm {

namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

struct Tetrahedron {
    std::array<int, 4> nodes;
    Vector6 rest_square; ///< l0^2 of each edge [m^2]
    Matrix6 coupling;    ///< k_ef [N/m^3]
};

Tetrahedron make_tetrahedron(const Eigen::VectorXd &rest, const std::array<int, 4> &nodes,
                             const core::Material &material) {
    Tetrahedron result{.nodes = nodes, .rest_square = {}, .coupling = {}};
    const auto [volume, gradient] = volume_gradient(rest, nodes);
    std::array<Eigen::Matrix3d, 6> dual;
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        result.rest_square[e] = (of_node(rest, nodes[j]) - of_node(rest, nodes[i])).squaredNorm();
        const Eigen::Matrix3d product = gradient[i] * gradient[j].transpose() / (volume * volume);
        dual[e] = -0.5 * (product + product.transpose());
    }
    for (int e = 0; e < 6; ++e)
        for (int f = 0; f < 6; ++f)
            result.coupling(e, f) = volume * (material.lame_lambda() * dual[e].trace() * dual[f].trace() +
                                              2.0 * material.shear_modulus() * dual[e].cwiseProduct(dual[f]).sum());
    return result;
}

class BiquadraticSprings : public ElasticTerm {
  public:
    explicit BiquadraticSprings(const core::Body &body) {
        const auto rest = to_unknowns(body.mesh.points);
        tetrahedra_.reserve(body.mesh.tetrahedra.size());
        for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t)
            tetrahedra_.push_back(make_tetrahedron(rest, body.mesh.tetrahedra[t], body.materials[body.mesh.region[t]]));
    }

    double energy(const Eigen::VectorXd &x) const override {
        double energy = 0.0;
        for (const auto &tetrahedron : tetrahedra_) {
            const Vector6 q = stretch(tetrahedron, spans(tetrahedron, x));
            energy += 0.125 * q.dot(tetrahedron.coupling * q);
        }
        return energy;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        for (const auto &tetrahedron : tetrahedra_) {
            const auto span = spans(tetrahedron, x);
            Vector6 q = stretch(tetrahedron, span);
            if (beta != 0.0) {
                const auto rate = spans(tetrahedron, v);
                for (int e = 0; e < 6; ++e)
                    q[e] += 2.0 * beta * span[e].dot(rate[e]);
            }
            const Vector6 tension = 0.5 * tetrahedron.coupling * q;
            for (int e = 0; e < 6; ++e) {
                const auto [i, j] = core::tetrahedron_edges[e];
                of_node(force, tetrahedron.nodes[i]) += tension[e] * span[e];
                of_node(force, tetrahedron.nodes[j]) -= tension[e] * span[e];
            }
        }
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(144 * tetrahedra_.size());
        for (const auto &tetrahedron : tetrahedra_) {
            const Matrix12 block = tetrahedron_hessian(tetrahedron, x, tangent);
            for (int row = 0; row < 12; ++row)
                for (int column = 0; column < 12; ++column)
                    entries.emplace_back(3 * tetrahedron.nodes[row / 3] + row % 3,
                                         3 * tetrahedron.nodes[column / 3] + column % 3, block(row, column));
        }
        Eigen::SparseMatrix<double> hessian(x.size(), x.size());
        hessian.setFromTriplets(entries.begin(), entries.end());
        return hessian;
    }

    /// With K = sum of K_t over tetrahedra and K_t positive semi-definite, u^T K_t u <= 4 sum of u_a^T (K_t)_aa u_a.
    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        for (const auto &tetrahedron : tetrahedra_) {
            const Matrix12 block = tetrahedron_hessian(tetrahedron, x, Tangent::material);
            for (int a = 0; a < 4; ++a)
                blocks[tetrahedron.nodes[a]] += 4.0 * block.block<3, 3>(3 * a, 3 * a);
        }
    }

  private:
    using Spans = std::array<core::Vector3, 6>;

    /// Differences of a field along the edges.
    static Spans spans(const Tetrahedron &tetrahedron, const Eigen::VectorXd &field) {
        Spans span;
        for (int e = 0; e < 6; ++e) {
            const auto [i, j] = core::tetrahedron_edges[e];
            span[e] = of_node(field, tetrahedron.nodes[j]) - of_node(field, tetrahedron.nodes[i]);
        }
        return span;
    }

    static Vector6 stretch(const Tetrahedron &tetrahedron, const Spans &span) {
        Vector6 q;
        for (int e = 0; e < 6; ++e)
            q[e] = span[e].squaredNorm() - tetrahedron.rest_square[e];
        return q;
    }

    static Matrix12 tetrahedron_hessian(const Tetrahedron &tetrahedron, const Eigen::VectorXd &x, Tangent tangent) {
        const auto span = spans(tetrahedron, x);
        Eigen::Matrix<double, 12, 6> slope = Eigen::Matrix<double, 12, 6>::Zero(); // dq_e/dx
        for (int e = 0; e < 6; ++e) {
            const auto [i, j] = core::tetrahedron_edges[e];
            slope.block<3, 1>(3 * i, e) = -2.0 * span[e];
            slope.block<3, 1>(3 * j, e) = 2.0 * span[e];
        }
        Matrix12 hessian = 0.25 * slope * tetrahedron.coupling * slope.transpose();
        if (tangent == Tangent::material)
            return hessian;
        const Vector6 tension = 0.5 * tetrahedron.coupling * stretch(tetrahedron, span);
        for (int e = 0; e < 6; ++e) {
            const auto [i, j] = core::tetrahedron_edges[e];
            const Eigen::Matrix3d part = (tangent == Tangent::semi_definite ? std::max(tension[e], 0.0) : tension[e]) *
                                         Eigen::Matrix3d::Identity();
            hessian.block<3, 3>(3 * i, 3 * i) += part;
            hessian.block<3, 3>(3 * j, 3 * j) += part;
            hessian.block<3, 3>(3 * i, 3 * j) -= part;
            hessian.block<3, 3>(3 * j, 3 * i) -= part;
        }
        return hessian;
    }

    std::vector<Tetrahedron> tetrahedra_;
};

} // namespace

std::shared_ptr<const ElasticTerm> biquadratic_springs(const core::Body &body) {
    return std::make_shared<BiquadraticSprings>(body);
}

} // namespace livermark::msm
