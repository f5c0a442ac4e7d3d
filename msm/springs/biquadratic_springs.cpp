#include "msm/springs/biquadratic_springs.hpp"

#include <algorithm>

#include "msm/dynamics/step_parts.hpp"
#include "msm/springs/edge_stretches.hpp"
#include "msm/springs/tetrahedron_volume.hpp"

namespace livermark::msm {

namespace {

using Matrix12 = Eigen::Matrix<double, 12, 12>;

struct CoupledTetrahedron {
    std::array<int, 4> nodes;
    double lame_lambda, shear_modulus; ///< [Pa]
    Vector6 rest_square;               ///< l0^2 of each edge [m^2]
    Matrix6 coupling;                  ///< k_ef [N/m^3]
};

CoupledTetrahedron make_tetrahedron(const Eigen::VectorXd &rest, const std::array<int, 4> &nodes,
                                    const core::Material &material) {
    const Matrix6 strain = strain_of_stretches(rest, nodes);
    return {.nodes = nodes,
            .lame_lambda = material.lame_lambda(),
            .shear_modulus = material.shear_modulus(),
            .rest_square = squared_lengths(edge_spans(nodes, rest)),
            .coupling = 4.0 * volume_gradient(rest, nodes).volume * strain.transpose() *
                        isotropic_stiffness(material.lame_lambda(), material.shear_modulus()) * strain};
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
            const Vector6 q = stretch(tetrahedron, edge_spans(tetrahedron.nodes, x));
            energy += 0.125 * q.dot(tetrahedron.coupling * q);
        }
        return energy;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        for (const auto &tetrahedron : tetrahedra_) {
            const auto spans = edge_spans(tetrahedron.nodes, x);
            Vector6 q = stretch(tetrahedron, spans);
            if (beta != 0.0)
                q += beta * stretch_rates(spans, edge_spans(tetrahedron.nodes, v));
            add_tensions(tetrahedron.nodes, spans, 0.5 * tetrahedron.coupling * q, force);
        }
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(144 * tetrahedra_.size());
        for (const auto &tetrahedron : tetrahedra_) {
            const Matrix12 block = tetrahedron_hessian(tetrahedron, x, tangent);
            add_block(entries, tetrahedron.nodes, block);
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

    bool describe(StepParts &parts) const override {
        parts.tetrahedra.clear();
        for (const auto &tetrahedron : tetrahedra_) {
            parts.tetrahedra.push_back(tetrahedron.nodes);
            parts.lame_lambda.push_back(tetrahedron.lame_lambda);
            parts.shear_modulus.push_back(tetrahedron.shear_modulus);
        }
        return true;
    }

  private:
    static Vector6 stretch(const CoupledTetrahedron &tetrahedron, const EdgeVectors &spans) {
        return squared_lengths(spans) - tetrahedron.rest_square;
    }

    static Matrix12 tetrahedron_hessian(const CoupledTetrahedron &tetrahedron, const Eigen::VectorXd &x,
                                        Tangent tangent) {
        const auto spans = edge_spans(tetrahedron.nodes, x);
        const auto slope = stretch_slopes(spans);
        Matrix12 hessian = 0.25 * slope * tetrahedron.coupling * slope.transpose();
        if (tangent == Tangent::material)
            return hessian;
        Vector6 tension = 0.5 * tetrahedron.coupling * stretch(tetrahedron, spans);
        if (tangent == Tangent::semi_definite)
            tension = tension.cwiseMax(0.0);
        std::array<Eigen::Matrix3d, 6> of_span;
        for (int e = 0; e < 6; ++e)
            of_span[e] = tension[e] * Eigen::Matrix3d::Identity();
        return hessian + hessian_of_edges(of_span);
    }

    std::vector<CoupledTetrahedron> tetrahedra_;
};

} // namespace

std::shared_ptr<const ElasticTerm> biquadratic_springs(const core::Body &body) {
    return std::make_shared<BiquadraticSprings>(body);
}

std::shared_ptr<const ElasticTerm> linear_elements(const core::Body &body) {
    // At Poisson's ratio 0.45, lambda = 9 mu, nodal_springs take 49 and 53 steps with 2.5 mu, 62 and 67 with 12 mu; at
    // 0.49, 49 mu, they do not come to an end within 120 with 2.5 mu, and take 100 and 104 with 12 mu.
    constexpr double usual = 2.5, nearly_incompressible = 12.0, limit = 10.0;
    auto softer = body;
    for (auto &material : softer.materials) {
        const double mu = material.shear_modulus();
        const double ratio = material.lame_lambda() > limit * mu ? nearly_incompressible : usual;
        const double lambda = std::min(material.lame_lambda(), ratio * mu);
        material.poisson_ratio = 0.5 * lambda / (lambda + mu);
        material.young_modulus = 2.0 * mu * (1.0 + material.poisson_ratio);
    }
    return biquadratic_springs(softer);
}

} // namespace livermark::msm
