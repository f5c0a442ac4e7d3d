#include "msm/hyperelastic_springs.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "msm/biquadratic_springs.hpp"
#include "msm/dynamics/step_parts.hpp"
#include "msm/mass_lumping.hpp"
#include "msm/nodal_parts.hpp"
#include "msm/springs_with_volume.hpp"
#include "msm/tetrahedron_volume.hpp"

namespace livermark::msm {

namespace {

using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Six = std::vector<Vector6>;

/// Of the stiffness, inside each tetrahedron.

struct SpringTetrahedron {
    std::array<int, 4> nodes;
    std::array<int, 4> parts;  // around its corners
    double volume;             // V_t [m^3]
    double shear_modulus;      // [Pa]
    Vector6 rest_square;       // l0^2 of each edge [m^2]
    Matrix6 strain_of_stretch; // [1/m^2]
};

/// Without what is negative.
Matrix6 semi_definite_part(const Matrix6 &matrix) {
    const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(matrix);
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

class HyperelasticSprings : public ElasticTerm {
  public:
    HyperelasticSprings(const core::Body &body, SpringEnergy energy, double alone)
        : energy_(std::move(energy)), alone_(alone) {
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
                                   .rest_square = squared_lengths(edge_spans(nodes, rest)),
                                   .strain_of_stretch = strain_of_stretches(rest, nodes)});
        }
    }

    double energy(const Eigen::VectorXd &x) const override {
        for (const auto &tetrahedron : tetrahedra_)
            if (!(volume_gradient(x, tetrahedron.nodes).volume > 0.0))
                return std::numeric_limits<double>::infinity();
        const auto strain = strains(x);
        double energy = 0.0;
        if (alone_ > 0.0)
            for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
                energy +=
                    alone_ * tetrahedra_[t].volume * energy_.energy(tetrahedra_[t].shear_modulus, tensor(strain[t]));
        const auto mean = means(strain);
        for (std::size_t c = 0; c < mean.size(); ++c)
            energy += (1.0 - alone_) * part_volume_[c] * energy_.energy(part_modulus_[c], tensor(mean[c]));
        return energy;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        const auto tension = tensions(x, v, beta);
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            add_tensions(tetrahedra_[t].nodes, edge_spans(tetrahedra_[t].nodes, x), tension[t], force);
    }

    /// The tensions that small displacements add along the edges, and what the tensions that are there do when these
    /// turn.
    void add_hessian_product(const Eigen::VectorXd &x, const Eigen::VectorXd &u,
                             Eigen::VectorXd &product) const override {
        const auto strain = strains(x);
        const auto mean = means(strain);
        const auto added = strain_rates(x, u);
        auto nodal = means(added);
        for (std::size_t c = 0; c < nodal.size(); ++c)
            nodal[c] = (1.0 - alone_) * (moduli(part_modulus_[c], mean[c], Tangent::exact) * nodal[c]);
        const auto tension = tensions(x, x, 0.0);
        Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto &tetrahedron = tetrahedra_[t];
            const Vector6 stress = alone_ * (moduli(tetrahedron.shear_modulus, strain[t], Tangent::exact) * added[t]);
            add_tensions(tetrahedron.nodes, edge_spans(tetrahedron.nodes, x), edge_tensions(tetrahedron, stress, nodal),
                         force);
            add_tensions(tetrahedron.nodes, edge_spans(tetrahedron.nodes, u), tension[t], force);
        }
        product -= force;
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        const auto strain = strains(x);
        const auto mean = means(strain);
        Eigen::SparseMatrix<double> stiffness(6 * static_cast<Eigen::Index>(mean.size()),
                                              6 * static_cast<Eigen::Index>(mean.size()));
        stiffness.reserve(Eigen::VectorXi::Constant(stiffness.cols(), 6));
        for (std::size_t c = 0; c < mean.size(); ++c) {
            const Matrix6 block = (1.0 - alone_) * part_volume_[c] * moduli(part_modulus_[c], mean[c], tangent);
            const auto first = 6 * static_cast<Eigen::Index>(c);
            for (int column = 0; column < 6; ++column)
                for (int row = 0; row < 6; ++row)
                    stiffness.insert(first + row, first + column) = block(row, column);
        }
        const auto mean_slope = mean_strain_slopes(x);
        const Eigen::SparseMatrix<double> stress_slope = stiffness * mean_slope;
        Eigen::SparseMatrix<double> hessian = Eigen::SparseMatrix<double>(mean_slope.transpose()) * stress_slope;
        hessian += tetrahedra_hessian(x, strain, tangent);
        return hessian;
    }

    /// As of nodal springs: a mean costs no more than what it is of, and u^T K_t u <= 4 sum of u_a^T (K_t)_aa u_a.
    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        for (const auto &tetrahedron : tetrahedra_) {
            const auto slope = strain_slope(tetrahedron, x);
            const double mu = tetrahedron.shear_modulus;
            const Matrix12 block = tetrahedron.volume * slope.transpose() * isotropic_stiffness(mu, mu) * slope;
            for (int a = 0; a < 4; ++a)
                blocks[tetrahedron.nodes[a]] += 4.0 * block.block<3, 3>(3 * a, 3 * a);
        }
    }

    bool describe(StepParts &parts) const override {
        if (!energy_.in_kernels)
            return false;
        parts.coupled_energy = *energy_.in_kernels;
        return describe_coupled_springs(tetrahedra_, part_node_, part_modulus_, alone_, parts);
    }

  private:
    /// d2 W_s / dE2
    Matrix6 moduli(double shear_modulus, const Vector6 &strain, Tangent tangent) const {
        if (tangent == Tangent::material)
            return isotropic_stiffness(shear_modulus, shear_modulus);
        const Matrix6 exact = energy_.stiffness(shear_modulus, tensor(strain));
        return tangent == Tangent::exact ? exact : semi_definite_part(exact);
    }

    Vector6 stress(double shear_modulus, const Vector6 &strain) const {
        return components(energy_.stress(shear_modulus, tensor(strain)));
    }

    /// E_t
    Six strains(const Eigen::VectorXd &x) const {
        Six strain(tetrahedra_.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            strain[t] = tetrahedra_[t].strain_of_stretch *
                        (squared_lengths(edge_spans(tetrahedra_[t].nodes, x)) - tetrahedra_[t].rest_square);
        return strain;
    }

    /// The rate of E_t.
    Six strain_rates(const Eigen::VectorXd &x, const Eigen::VectorXd &v) const {
        Six rate(tetrahedra_.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            rate[t] = tetrahedra_[t].strain_of_stretch *
                      stretch_rates(edge_spans(tetrahedra_[t].nodes, x), edge_spans(tetrahedra_[t].nodes, v));
        return rate;
    }

    /// E_c
    Six means(const Six &strain) const { return nodal_means(tetrahedra_, part_volume_, strain); }

    /// Of each edge in each tetrahedron, 2 dU/dq_e, and what its dashpots add [N/m].
    Six tensions(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta) const {
        auto inner = strains(x);
        auto nodal = means(inner);
        for (std::size_t c = 0; c < nodal.size(); ++c)
            nodal[c] = (1.0 - alone_) * stress(part_modulus_[c], nodal[c]);
        for (std::size_t t = 0; t < inner.size(); ++t)
            inner[t] = alone_ * stress(tetrahedra_[t].shear_modulus, inner[t]);
        if (beta != 0.0) {
            const auto rate = strain_rates(x, v);
            const auto mean_rate = means(rate);
            const auto viscous = [beta](double part, double mu, const Vector6 &of) -> Vector6 {
                return beta * part * isotropic_stiffness(mu, mu) * of;
            };
            for (std::size_t c = 0; c < nodal.size(); ++c)
                nodal[c] += viscous(1.0 - alone_, part_modulus_[c], mean_rate[c]);
            for (std::size_t t = 0; t < inner.size(); ++t)
                inner[t] += viscous(alone_, tetrahedra_[t].shear_modulus, rate[t]);
        }
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            inner[t] = edge_tensions(tetrahedra_[t], inner[t], nodal);
        return inner;
    }

    /// What the edges of a tetrahedron bear of the stress inside it and of those around its corners [N/m].
    static Vector6 edge_tensions(const SpringTetrahedron &tetrahedron, Vector6 stress, const Six &nodal) {
        for (const int part : tetrahedron.parts)
            stress += 0.25 * nodal[part];
        return 2.0 * tetrahedron.volume * (tetrahedron.strain_of_stretch.transpose() * stress);
    }

    static Eigen::Matrix<double, 6, 12> strain_slope(const SpringTetrahedron &tetrahedron, const Eigen::VectorXd &x) {
        return tetrahedron.strain_of_stretch * stretch_slopes(edge_spans(tetrahedron.nodes, x)).transpose();
    }

    /// (6C, 3N) dE_c/dx
    Eigen::SparseMatrix<double> mean_strain_slopes(const Eigen::VectorXd &x) const {
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(288 * tetrahedra_.size());
        for (const auto &tetrahedron : tetrahedra_) {
            const auto slope = strain_slope(tetrahedron, x);
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
    Eigen::SparseMatrix<double> tetrahedra_hessian(const Eigen::VectorXd &x, const Six &strain, Tangent tangent) const {
        const auto tension = tensions(x, x, 0.0);
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(144 * tetrahedra_.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto &tetrahedron = tetrahedra_[t];
            const auto slope = strain_slope(tetrahedron, x);
            const Matrix6 inside = alone_ * tetrahedron.volume * moduli(tetrahedron.shear_modulus, strain[t], tangent);
            Matrix12 block = slope.transpose() * inside * slope;
            if (tangent != Tangent::material) {
                std::array<Eigen::Matrix3d, 6> of_span;
                for (int e = 0; e < 6; ++e)
                    of_span[e] = (tangent == Tangent::exact ? tension[t][e] : std::max(tension[t][e], 0.0)) *
                                 Eigen::Matrix3d::Identity();
                block += hessian_of_edges(of_span);
            }
            add_block(entries, tetrahedron.nodes, block);
        }
        Eigen::SparseMatrix<double> hessian(x.size(), x.size());
        hessian.setFromTriplets(entries.begin(), entries.end());
        return hessian;
    }

    SpringEnergy energy_;
    double alone_;
    std::vector<SpringTetrahedron> tetrahedra_;
    std::vector<int> part_node_;       // (C)
    std::vector<double> part_volume_;  // (C) [m^3]
    std::vector<double> part_modulus_; // (C) [Pa]
};

} // namespace

std::shared_ptr<const ElasticTerm> hyperelastic_springs(const core::Body &body, const SpringEnergy &energy,
                                                        double alone) {
    return std::make_shared<HyperelasticSprings>(body, energy, alone);
}

ElasticBody hyperelastic_springs_with_volume(const core::Body &body, const SpringEnergy &energy, double alone) {
    std::vector<std::shared_ptr<const ElasticTerm>> terms{hyperelastic_springs(body, energy, alone)};
    if (needs_volume(body)) {
        std::vector<double> modulus;
        for (const auto &material : body.materials)
            modulus.push_back(modulus_beside_springs(material));
        auto volumes = mean_volumes_around_nodes(nodal_parts(body), modulus);
        volumes.measure = energy.volume;
        terms.push_back(volume_penalty(body.mesh, volumes));
    }
    ElasticBody springs(lumped_masses(body), std::move(terms));
    springs.preconditioner = linear_elements(body);
    return springs;
}

} // namespace livermark::msm
