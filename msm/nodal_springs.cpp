#include "msm/nodal_springs.hpp"

#include "msm/biquadratic_springs.hpp"
#include "msm/dynamics/step_parts.hpp"
#include "msm/edge_stretches.hpp"
#include "msm/inversion_guard.hpp"
#include "msm/mass_lumping.hpp"
#include "msm/nodal_parts.hpp"
#include "msm/springs_with_volume.hpp"
#include "msm/tetrahedron_volume.hpp"

namespace livermark::msm {

namespace {

using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Strains = std::vector<Vector6>;

struct Tetrahedron {
    std::array<int, 4> nodes;
    std::array<int, 4> parts;  // around its corners
    double volume;             // V_t [m^3]
    double shear_modulus;      // [Pa]
    Vector6 rest_length;       // l0 of each edge [m]
    Matrix6 strain_of_stretch; // [1/m^2]
};

Vector6 stress(double shear_modulus, const Vector6 &strain) {
    Vector6 result = 2.0 * shear_modulus * strain;
    result.head<3>().array() += shear_modulus * strain.head<3>().sum();
    return result;
}

class NodalSprings : public ElasticTerm {
  public:
    NodalSprings(const core::Body &body, double alone) : alone_(alone) {
        const auto parts = nodal_parts(body);
        part_volume_ = parts.volume;
        part_node_ = parts.node;
        for (const int region : parts.region)
            part_modulus_.push_back(body.materials[region].shear_modulus());
        const auto rest = to_unknowns(body.mesh.points);
        tetrahedra_.reserve(body.mesh.tetrahedra.size());
        for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t) {
            const auto &nodes = body.mesh.tetrahedra[t];
            tetrahedra_.push_back({.nodes = nodes,
                                   .parts = parts.at_corner[t],
                                   .volume = parts.tetrahedron_volume[t],
                                   .shear_modulus = body.materials[body.mesh.region[t]].shear_modulus(),
                                   .rest_length = squared_lengths(edge_spans(nodes, rest)).cwiseSqrt(),
                                   .strain_of_stretch = strain_of_stretches(rest, nodes)});
        }
    }

    double energy(const Eigen::VectorXd &x) const override {
        const auto strain = strains(x, x, 0.0);
        double energy = 0.0;
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            energy +=
                0.5 * alone_ * tetrahedra_[t].volume * strain[t].dot(stress(tetrahedra_[t].shear_modulus, strain[t]));
        const auto mean = means(strain);
        for (std::size_t c = 0; c < mean.size(); ++c)
            energy += 0.5 * (1.0 - alone_) * part_volume_[c] * mean[c].dot(stress(part_modulus_[c], mean[c]));
        return energy;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        const auto tension = tensions(strains(x, v, beta));
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            add_tensions(tetrahedra_[t].nodes, edges(tetrahedra_[t], x).pull, tension[t], force);
    }

    void add_hessian_product(const Eigen::VectorXd &x, const Eigen::VectorXd &u,
                             Eigen::VectorXd &product) const override {
        Strains added(tetrahedra_.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            added[t] = tetrahedra_[t].strain_of_stretch *
                       stretch_rates(edges(tetrahedra_[t], x).pull, edge_spans(tetrahedra_[t].nodes, u));
        const auto more = tensions(added), there = tensions(strains(x, x, 0.0));
        Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto &tetrahedron = tetrahedra_[t];
            const auto [length, pull] = edges(tetrahedron, x);
            auto turn = edge_spans(tetrahedron.nodes, u);
            for (int e = 0; e < 6; ++e) {
                const core::Vector3 direction = pull[e].normalized();
                turn[e] = tetrahedron.rest_length[e] / length[e] * (turn[e] - direction.dot(turn[e]) * direction);
            }
            add_tensions(tetrahedron.nodes, pull, more[t], force);
            add_tensions(tetrahedron.nodes, turn, there[t], force);
        }
        product -= force;
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        const auto mean_slope = mean_strain_slopes(x);
        Eigen::SparseMatrix<double> stiffness(mean_slope.rows(), mean_slope.rows());
        stiffness.reserve(Eigen::VectorXi::Constant(mean_slope.rows(), 6));
        for (std::size_t c = 0; c < part_volume_.size(); ++c) {
            const Matrix6 block =
                (1.0 - alone_) * part_volume_[c] * isotropic_stiffness(part_modulus_[c], part_modulus_[c]);
            for (int column = 0; column < 6; ++column)
                for (int row = 0; row < 6; ++row)
                    stiffness.insert(6 * static_cast<Eigen::Index>(c) + row,
                                     6 * static_cast<Eigen::Index>(c) + column) = block(row, column);
        }
        const Eigen::SparseMatrix<double> stress_slope = stiffness * mean_slope;
        Eigen::SparseMatrix<double> hessian = Eigen::SparseMatrix<double>(mean_slope.transpose()) * stress_slope;
        hessian += tetrahedra_hessian(x, tangent);
        return hessian;
    }

    /// The mean of a strain costs no more than the mean of what each strain costs, so u^T K u is at most what it would
    /// be with all stiffness inside the tetrahedra, and there u^T K_t u <= 4 sum of u_a^T (K_t)_aa u_a.
    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        for (const auto &tetrahedron : tetrahedra_) {
            const Matrix12 block = stiffness_inside(tetrahedron, x);
            for (int a = 0; a < 4; ++a)
                blocks[tetrahedron.nodes[a]] += 4.0 * block.block<3, 3>(3 * a, 3 * a);
        }
    }

    bool describe(StepParts &parts) const override {
        return describe_coupled_springs(tetrahedra_, part_node_, part_modulus_, alone_, parts);
    }

  private:
    /// The six edges of a tetrahedron as they are: how long [m], and which way, times l0 [m].
    struct Edges {
        Vector6 length;
        EdgeVectors pull;
    };

    static Edges edges(const Tetrahedron &tetrahedron, const Eigen::VectorXd &x) {
        Edges result{.length = {}, .pull = edge_spans(tetrahedron.nodes, x)};
        result.length = squared_lengths(result.pull).cwiseSqrt();
        for (int e = 0; e < 6; ++e)
            result.pull[e] *= tetrahedron.rest_length[e] / result.length[e];
        return result;
    }

    /// E_t(x), and beta times its rate at the velocities v
    Strains strains(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta) const {
        Strains strain(tetrahedra_.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto &tetrahedron = tetrahedra_[t];
            const auto [length, pull] = edges(tetrahedron, x);
            Vector6 stretch = 2.0 * tetrahedron.rest_length.cwiseProduct(length - tetrahedron.rest_length);
            if (beta != 0.0)
                stretch += beta * stretch_rates(pull, edge_spans(tetrahedron.nodes, v));
            strain[t] = tetrahedron.strain_of_stretch * stretch;
        }
        return strain;
    }

    /// E_c
    Strains means(const Strains &strain) const { return nodal_means(tetrahedra_, part_volume_, strain); }

    /// Of each edge in each tetrahedron, 2 dU/dq_e [N/m].
    Strains tensions(const Strains &strain) const {
        auto nodal_stress = means(strain);
        for (std::size_t c = 0; c < nodal_stress.size(); ++c)
            nodal_stress[c] = stress((1.0 - alone_) * part_modulus_[c], nodal_stress[c]);
        Strains tension(tetrahedra_.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto &tetrahedron = tetrahedra_[t];
            Vector6 sum = stress(alone_ * tetrahedron.shear_modulus, strain[t]);
            for (const int part : tetrahedron.parts)
                sum += 0.25 * nodal_stress[part];
            tension[t] = 2.0 * tetrahedron.volume * tetrahedron.strain_of_stretch.transpose() * sum;
        }
        return tension;
    }

    /// (6C, 3N) dE_c/dx
    Eigen::SparseMatrix<double> mean_strain_slopes(const Eigen::VectorXd &x) const {
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(288 * tetrahedra_.size());
        for (const auto &tetrahedron : tetrahedra_) {
            const Eigen::Matrix<double, 6, 12> slope = strain_slope(tetrahedron, x);
            for (const int part : tetrahedron.parts)
                for (int column = 0; column < 12; ++column)
                    for (int row = 0; row < 6; ++row)
                        entries.emplace_back(6 * part + row, 3 * tetrahedron.nodes[column / 3] + column % 3,
                                             share_of_part(tetrahedron, part, part_volume_) * slope(row, column));
        }
        Eigen::SparseMatrix<double> slopes(6 * static_cast<Eigen::Index>(part_volume_.size()), x.size());
        slopes.setFromTriplets(entries.begin(), entries.end());
        return slopes;
    }

    /// What stays inside the tetrahedra, and what the tensions of all add when edges turn.
    Eigen::SparseMatrix<double> tetrahedra_hessian(const Eigen::VectorXd &x, Tangent tangent) const {
        const auto tension = tensions(strains(x, x, 0.0));
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(144 * tetrahedra_.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto &nodes = tetrahedra_[t].nodes;
            Matrix12 block = alone_ * stiffness_inside(tetrahedra_[t], x);
            if (tangent == Tangent::exact)
                block += turning_hessian(tetrahedra_[t], x, tension[t]);
            else if (tangent == Tangent::semi_definite)
                block += turning_hessian(tetrahedra_[t], x, tension[t].cwiseMax(0.0));
            add_block(entries, nodes, block);
        }
        Eigen::SparseMatrix<double> hessian(x.size(), x.size());
        hessian.setFromTriplets(entries.begin(), entries.end());
        return hessian;
    }

    /// What tensions add that stay the same when the edges turn.
    static Matrix12 turning_hessian(const Tetrahedron &tetrahedron, const Eigen::VectorXd &x, const Vector6 &tension) {
        const auto [length, pull] = edges(tetrahedron, x);
        std::array<Eigen::Matrix3d, 6> of_span;
        for (int e = 0; e < 6; ++e) {
            const core::Vector3 direction = pull[e].normalized();
            of_span[e] = tension[e] * tetrahedron.rest_length[e] / length[e] *
                         (Eigen::Matrix3d::Identity() - direction * direction.transpose());
        }
        return hessian_of_edges(of_span);
    }

    static Eigen::Matrix<double, 6, 12> strain_slope(const Tetrahedron &tetrahedron, const Eigen::VectorXd &x) {
        return tetrahedron.strain_of_stretch * stretch_slopes(edges(tetrahedron, x).pull).transpose();
    }

    static Matrix12 stiffness_inside(const Tetrahedron &tetrahedron, const Eigen::VectorXd &x) {
        const auto slope = strain_slope(tetrahedron, x);
        return tetrahedron.volume * slope.transpose() *
               isotropic_stiffness(tetrahedron.shear_modulus, tetrahedron.shear_modulus) * slope;
    }

    double alone_;
    std::vector<Tetrahedron> tetrahedra_;
    std::vector<int> part_node_;       // (C)
    std::vector<double> part_volume_;  // (C) [m^3]
    std::vector<double> part_modulus_; // (C) [Pa]
};

} // namespace

std::shared_ptr<const ElasticTerm> nodal_springs(const core::Body &body, double alone) {
    return std::make_shared<NodalSprings>(body, alone);
}

ElasticBody nodal_springs_with_volume(const core::Body &body, double alone) {
    std::vector<std::shared_ptr<const ElasticTerm>> terms{nodal_springs(body, alone)};
    if (needs_volume(body))
        terms.push_back(volume_beside_springs(body, find_volume_term("mean_nodal_volume")));
    terms.push_back(inversion_guard(body));
    ElasticBody springs(lumped_masses(body), std::move(terms));
    springs.preconditioner = linear_elements(body);
    return springs;
}

} // namespace livermark::msm
