#include "msm/springs/tetrahedron.hpp"

#include <algorithm>
#include <cmath>

#include "msm/elastic_body.hpp"

namespace livermark::msm {

namespace {

/// Edges from corner 0 to the others.
std::array<core::Vector3, 3> edges_from_first(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron) {
    const auto corner = [&](int a) -> core::Vector3 {
        return x.segment<3>(3 * static_cast<Eigen::Index>(tetrahedron[a]));
    };
    const core::Vector3 origin = corner(0);
    return {corner(1) - origin, corner(2) - origin, corner(3) - origin};
}

/// The matrix of a x .
Eigen::Matrix3d cross_matrix(const core::Vector3 &a) {
    return (Eigen::Matrix3d() << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0).finished();
}

} // namespace

Eigen::Matrix<double, 12, 12> volume_hessian(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron) {
    const auto edges = edges_from_first(x, tetrahedron);
    Eigen::Matrix<double, 12, 12> hessian = Eigen::Matrix<double, 12, 12>::Zero();
    // 6 dV/da = b x c, so that its derivative in b is -[c x] and in c [b x], and so on in a circle.
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3, last = (k + 2) % 3;
        hessian.block<3, 3>(3 * (k + 1), 3 * (next + 1)) = -cross_matrix(edges[last]) / 6.0;
        hessian.block<3, 3>(3 * (k + 1), 3 * (last + 1)) = cross_matrix(edges[next]) / 6.0;
    }
    // A common shift changes nothing.
    for (int k = 1; k < 4; ++k)
        for (int m = 1; m < 4; ++m) {
            hessian.block<3, 3>(0, 3 * m) -= hessian.block<3, 3>(3 * k, 3 * m);
            hessian.block<3, 3>(3 * k, 0) -= hessian.block<3, 3>(3 * k, 3 * m);
        }
    for (int k = 1; k < 4; ++k)
        hessian.block<3, 3>(0, 0) -= hessian.block<3, 3>(3 * k, 0);
    return hessian;
}

void add_block(std::vector<Eigen::Triplet<double>> &entries, const std::array<int, 4> &tetrahedron,
               const Eigen::Matrix<double, 12, 12> &block) {
    for (int row = 0; row < 12; ++row)
        for (int column = 0; column < 12; ++column)
            entries.emplace_back(3 * tetrahedron[row / 3] + row % 3, 3 * tetrahedron[column / 3] + column % 3,
                                 block(row, column));
}

EdgeVectors edge_spans(const std::array<int, 4> &nodes, const Eigen::VectorXd &field) {
    EdgeVectors spans;
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        spans[e] = of_node(field, nodes[j]) - of_node(field, nodes[i]);
    }
    return spans;
}

Vector6 squared_lengths(const EdgeVectors &spans) {
    Vector6 result;
    for (int e = 0; e < 6; ++e)
        result[e] = spans[e].squaredNorm();
    return result;
}

Vector6 stretch_rates(const EdgeVectors &pulls, const EdgeVectors &rates) {
    Vector6 result;
    for (int e = 0; e < 6; ++e)
        result[e] = 2.0 * pulls[e].dot(rates[e]);
    return result;
}

Eigen::Matrix<double, 12, 6> stretch_slopes(const EdgeVectors &pulls) {
    Eigen::Matrix<double, 12, 6> slopes = Eigen::Matrix<double, 12, 6>::Zero();
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        slopes.block<3, 1>(3 * i, e) = -2.0 * pulls[e];
        slopes.block<3, 1>(3 * j, e) = 2.0 * pulls[e];
    }
    return slopes;
}

void add_tensions(const std::array<int, 4> &nodes, const EdgeVectors &pulls, const Vector6 &tension,
                  Eigen::VectorXd &force) {
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        of_node(force, nodes[i]) += tension[e] * pulls[e];
        of_node(force, nodes[j]) -= tension[e] * pulls[e];
    }
}

Eigen::Matrix<double, 12, 12> hessian_of_edges(const std::array<Eigen::Matrix3d, 6> &of_span) {
    Eigen::Matrix<double, 12, 12> hessian = Eigen::Matrix<double, 12, 12>::Zero();
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        hessian.block<3, 3>(3 * i, 3 * i) += of_span[e];
        hessian.block<3, 3>(3 * j, 3 * j) += of_span[e];
        hessian.block<3, 3>(3 * i, 3 * j) -= of_span[e];
        hessian.block<3, 3>(3 * j, 3 * i) -= of_span[e];
    }
    return hessian;
}

Matrix6 strain_of_stretches(const Eigen::VectorXd &rest, const std::array<int, 4> &nodes) {
    const auto [volume, gradient] = volume_gradient(rest, nodes);
    Matrix6 result;
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        const core::Vector3 a = gradient[i] / volume;
        const core::Vector3 b = gradient[j] / volume;
        for (int c = 0; c < 3; ++c) {
            const int d = (c + 1) % 3;
            result(c, e) = -0.5 * a[c] * b[c];
            result(3 + c, e) = -0.25 * std::sqrt(2.0) * (a[c] * b[d] + a[d] * b[c]);
        }
    }
    return result;
}

Eigen::Matrix3d tensor(const Vector6 &of) {
    const double xy = std::sqrt(0.5) * of[3], yz = std::sqrt(0.5) * of[4], zx = std::sqrt(0.5) * of[5];
    return (Eigen::Matrix3d() << of[0], xy, zx, xy, of[1], yz, zx, yz, of[2]).finished();
}

Vector6 components(const Eigen::Matrix3d &of) {
    Vector6 result;
    result << of(0, 0), of(1, 1), of(2, 2), std::sqrt(2.0) * of(0, 1), std::sqrt(2.0) * of(1, 2),
        std::sqrt(2.0) * of(2, 0);
    return result;
}

Matrix6 isotropic_stiffness(double lame_lambda, double shear_modulus) {
    Matrix6 result = 2.0 * shear_modulus * Matrix6::Identity();
    result.topLeftCorner<3, 3>().array() += lame_lambda;
    return result;
}

namespace {

using Matrix12 = Eigen::Matrix<double, 12, 12>;

struct CoupledTetrahedron {
    std::array<int, 4> nodes;
    double lame_lambda, shear_modulus; ///< [Pa]
    double volume;                     ///< [m^3]
    Vector6 rest_square;               ///< l0^2 of each edge [m^2]
    Matrix6 strain;                    ///< of stretches [1/m^2]
    Matrix6 coupling;                  ///< k_ef [N/m^3]
};

/// k_ef = 4 V strain^T stiffness strain
Matrix6 coupling_by(const CoupledTetrahedron &tetrahedron, const Matrix6 &stiffness) {
    return 4.0 * tetrahedron.volume * tetrahedron.strain.transpose() * stiffness * tetrahedron.strain;
}

/// Of the deviatoric part of a stress.
Matrix6 shape_stiffness(double shear_modulus) {
    return isotropic_stiffness(-2.0 / 3.0 * shear_modulus, shear_modulus);
}

CoupledTetrahedron make_tetrahedron(const Eigen::VectorXd &rest, const std::array<int, 4> &nodes,
                                    const core::Material &material) {
    CoupledTetrahedron made{.nodes = nodes,
                            .lame_lambda = material.lame_lambda(),
                            .shear_modulus = material.shear_modulus(),
                            .volume = volume_gradient(rest, nodes).volume,
                            .rest_square = squared_lengths(edge_spans(nodes, rest)),
                            .strain = strain_of_stretches(rest, nodes),
                            .coupling = {}};
    made.coupling = coupling_by(made, isotropic_stiffness(made.lame_lambda, made.shear_modulus));
    return made;
}

class LinearElements : public RelaxingTerm {
  public:
    explicit LinearElements(const core::Body &body) {
        const auto rest = to_unknowns(body.mesh.points);
        tetrahedra_.reserve(body.mesh.tetrahedra.size());
        for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t)
            tetrahedra_.push_back(make_tetrahedron(rest, body.mesh.tetrahedra[t], body.materials[body.mesh.region[t]]));
    }

    double energy(const Eigen::VectorXd &x) const override {
        double energy = 0.0;
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto &tetrahedron = tetrahedra_[t];
            const Vector6 q = stretch(tetrahedron, edge_spans(tetrahedron.nodes, x));
            energy += 0.125 * q.dot(tetrahedron.coupling * q);
            if (added_.size() > 0)
                energy += 0.5 * q.dot(added_tension(t));
        }
        return energy;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto &tetrahedron = tetrahedra_[t];
            const auto spans = edge_spans(tetrahedron.nodes, x);
            Vector6 q = stretch(tetrahedron, spans);
            if (beta != 0.0)
                q += beta * stretch_rates(spans, edge_spans(tetrahedron.nodes, v));
            Vector6 tension = 0.5 * tetrahedron.coupling * q;
            if (added_.size() > 0)
                tension += added_tension(t);
            add_tensions(tetrahedron.nodes, spans, tension, force);
        }
    }

    Eigen::VectorXd relaxing_stress(const Eigen::VectorXd &x) const override {
        Eigen::VectorXd stress(6 * static_cast<Eigen::Index>(tetrahedra_.size()));
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto &tetrahedron = tetrahedra_[t];
            const Vector6 q = stretch(tetrahedron, edge_spans(tetrahedron.nodes, x));
            stress.segment<6>(6 * static_cast<Eigen::Index>(t)) =
                shape_stiffness(part_ * tetrahedron.shear_modulus) * (tetrahedron.strain * q);
        }
        return stress;
    }

    void add_force_of(const Eigen::VectorXd &x, const Eigen::VectorXd &stress, Eigen::VectorXd &force) const override {
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            add_tensions(tetrahedra_[t].nodes, edge_spans(tetrahedra_[t].nodes, x), tension_of(stress, t), force);
    }

    Eigen::VectorXd relaxing_compliance() const override {
        Eigen::VectorXd compliance = Eigen::VectorXd::Zero(6 * static_cast<Eigen::Index>(tetrahedra_.size()));
        for (std::size_t t = 0; part_ > 0.0 && t < tetrahedra_.size(); ++t)
            compliance.segment<6>(6 * static_cast<Eigen::Index>(t))
                .setConstant(tetrahedra_[t].volume / (2.0 * part_ * tetrahedra_[t].shear_modulus));
        return compliance;
    }

    std::shared_ptr<const RelaxingTerm> relaxed(double part, const Eigen::VectorXd &added) const override {
        auto term = std::make_shared<LinearElements>(*this);
        term->part_ = part * part_;
        term->added_ = added;
        for (auto &tetrahedron : term->tetrahedra_) {
            const double mu = tetrahedron.shear_modulus;
            tetrahedron.coupling = coupling_by(tetrahedron, isotropic_stiffness(tetrahedron.lame_lambda, mu) -
                                                                (1.0 - term->part_) * shape_stiffness(mu));
        }
        return term;
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(144 * tetrahedra_.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            add_block(entries, tetrahedra_[t].nodes, tetrahedron_hessian(t, x, tangent));
        Eigen::SparseMatrix<double> hessian(x.size(), x.size());
        hessian.setFromTriplets(entries.begin(), entries.end());
        return hessian;
    }

    /// With K = sum of K_t over tetrahedra and K_t positive semi-definite, u^T K_t u <= 4 sum of u_a^T (K_t)_aa u_a.
    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const Matrix12 block = tetrahedron_hessian(t, x, Tangent::material);
            for (int a = 0; a < 4; ++a)
                blocks[tetrahedra_[t].nodes[a]] += 4.0 * block.block<3, 3>(3 * a, 3 * a);
        }
    }

    bool describe(StepParts & /*parts*/) const override { return false; }

  private:
    static Vector6 stretch(const CoupledTetrahedron &tetrahedron, const EdgeVectors &spans) {
        return squared_lengths(spans) - tetrahedron.rest_square;
    }

    /// 2 dU/dq [N/m] of second Piola-Kirchhoff stresses
    Vector6 tension_of(const Eigen::VectorXd &stress, std::size_t t) const {
        return 2.0 * tetrahedra_[t].volume * tetrahedra_[t].strain.transpose() *
               stress.segment<6>(6 * static_cast<Eigen::Index>(t));
    }

    Vector6 added_tension(std::size_t t) const { return tension_of(added_, t); }

    Matrix12 tetrahedron_hessian(std::size_t t, const Eigen::VectorXd &x, Tangent tangent) const {
        const auto &tetrahedron = tetrahedra_[t];
        const auto spans = edge_spans(tetrahedron.nodes, x);
        const auto slope = stretch_slopes(spans);
        Matrix12 hessian = 0.25 * slope * tetrahedron.coupling * slope.transpose();
        if (tangent == Tangent::material)
            return hessian;
        Vector6 tension = 0.5 * tetrahedron.coupling * stretch(tetrahedron, spans);
        if (added_.size() > 0)
            tension += added_tension(t);
        if (tangent == Tangent::semi_definite)
            tension = tension.cwiseMax(0.0);
        std::array<Eigen::Matrix3d, 6> of_span;
        for (int e = 0; e < 6; ++e)
            of_span[e] = tension[e] * Eigen::Matrix3d::Identity();
        return hessian + hessian_of_edges(of_span);
    }

    std::vector<CoupledTetrahedron> tetrahedra_;
    double part_ = 1.0;     // see RelaxingTerm::relaxed()
    Eigen::VectorXd added_; // (6 M) [Pa], or empty
};

} // namespace

std::shared_ptr<const ElasticTerm> linear_elements(const core::Body &body) {
    return std::make_shared<LinearElements>(body);
}

std::shared_ptr<const ElasticTerm> elements_of_softer_volume(const core::Body &body) {
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
    return linear_elements(softer);
}

} // namespace livermark::msm
