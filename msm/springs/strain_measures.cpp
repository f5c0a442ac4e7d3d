#include "msm/springs/strain_measures.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <span>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "core/semi_definite_part.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

double MeanLaw::energy(const Eigen::Matrix3d &strain) const {
    double energy = spring_energy.energy(mu, strain) + added.dot(components(strain));
    if (part != 1.0)
        energy -= (1.0 - part) * spring_energy.isochoric_energy(mu, strain);
    return energy;
}

Eigen::Matrix3d MeanLaw::stress(const Eigen::Matrix3d &strain) const {
    Eigen::Matrix3d stress = spring_energy.stress(mu, strain) + tensor(added);
    if (part != 1.0)
        stress -= (1.0 - part) * spring_energy.isochoric_stress(mu, strain);
    return stress;
}

Matrix6 MeanLaw::stiffness(const Eigen::Matrix3d &strain) const {
    Matrix6 stiffness = spring_energy.stiffness(mu, strain);
    if (part != 1.0)
        stiffness -= (1.0 - part) * spring_energy.isochoric_stiffness(mu, strain);
    return stiffness;
}

Matrix6 MeanLaw::stiffness_at_rest() const {
    return isotropic_stiffness(mu + 2.0 / 3.0 * (1.0 - part) * mu, part * mu);
}

StrainOfMean::Stiffness StrainOfMean::stiffness(const MeanLaw &law, const Value &strain, Tangent tangent) {
    if (tangent == Tangent::material)
        return law.stiffness_at_rest();
    const Matrix6 exact = law.stiffness(tensor(strain));
    return tangent == Tangent::exact ? exact : core::semi_definite_part(exact);
}

SquaredLengths::SquaredLengths(const std::array<int, 4> &nodes, const Eigen::VectorXd &rest)
    : StrainOfEdges(nodes, rest), rest_square_(squared_lengths(edge_spans(nodes, rest))) {}

Vector6 SquaredLengths::of(const Eigen::VectorXd &x) const {
    return strain_of_stretch_ * (squared_lengths(edge_spans(nodes_, x)) - rest_square_);
}

Vector6 SquaredLengths::rate(const Eigen::VectorXd &x, const Eigen::VectorXd &u) const {
    return strain_of_stretch_ * stretch_rates(edge_spans(nodes_, x), edge_spans(nodes_, u));
}

Eigen::Matrix<double, 6, 12> SquaredLengths::slope(const Eigen::VectorXd &x) const {
    return strain_of_stretch_ * stretch_slopes(edge_spans(nodes_, x)).transpose();
}

void SquaredLengths::add_force(const Eigen::VectorXd &x, const Value &stress, Eigen::VectorXd &force) const {
    add_tensions(nodes_, edge_spans(nodes_, x), tensions(stress), force);
}

void SquaredLengths::add_turning(const Eigen::VectorXd & /*x*/, const Eigen::VectorXd &u, const Value &stress,
                                 Eigen::VectorXd &force) const {
    add_tensions(nodes_, edge_spans(nodes_, u), tensions(stress), force);
}

Matrix12 SquaredLengths::curvature(const Eigen::VectorXd & /*x*/, const Value &stress, Tangent tangent) const {
    if (tangent == Tangent::material)
        return Matrix12::Zero();
    const Vector6 tension = tensions(stress);
    std::array<Eigen::Matrix3d, 6> of_span;
    for (int e = 0; e < 6; ++e)
        of_span[e] = (tangent == Tangent::exact ? tension[e] : std::max(tension[e], 0.0)) * Eigen::Matrix3d::Identity();
    return hessian_of_edges(of_span);
}

Elongations::Elongations(const std::array<int, 4> &nodes, const Eigen::VectorXd &rest)
    : StrainOfEdges(nodes, rest), rest_length_(squared_lengths(edge_spans(nodes, rest)).cwiseSqrt()) {}

Elongations::Edges Elongations::edges(const Eigen::VectorXd &x) const {
    Edges result{.length = {}, .pull = edge_spans(nodes_, x)};
    result.length = squared_lengths(result.pull).cwiseSqrt();
    for (int e = 0; e < 6; ++e)
        result.pull[e] *= rest_length_[e] / result.length[e];
    return result;
}

Vector6 Elongations::of(const Eigen::VectorXd &x) const {
    return strain_of_stretch_ * (2.0 * rest_length_.cwiseProduct(edges(x).length - rest_length_));
}

Vector6 Elongations::rate(const Eigen::VectorXd &x, const Eigen::VectorXd &u) const {
    return strain_of_stretch_ * stretch_rates(edges(x).pull, edge_spans(nodes_, u));
}

Eigen::Matrix<double, 6, 12> Elongations::slope(const Eigen::VectorXd &x) const {
    return strain_of_stretch_ * stretch_slopes(edges(x).pull).transpose();
}

void Elongations::add_force(const Eigen::VectorXd &x, const Value &stress, Eigen::VectorXd &force) const {
    add_tensions(nodes_, edges(x).pull, tensions(stress), force);
}

void Elongations::add_turning(const Eigen::VectorXd &x, const Eigen::VectorXd &u, const Value &stress,
                              Eigen::VectorXd &force) const {
    const auto [length, pull] = edges(x);
    auto turn = edge_spans(nodes_, u);
    for (int e = 0; e < 6; ++e) {
        const core::Vector3 direction = pull[e].normalized();
        turn[e] = rest_length_[e] / length[e] * (turn[e] - direction.dot(turn[e]) * direction);
    }
    add_tensions(nodes_, turn, tensions(stress), force);
}

Matrix12 Elongations::curvature(const Eigen::VectorXd &x, const Value &stress, Tangent tangent) const {
    if (tangent == Tangent::material)
        return Matrix12::Zero();
    const auto [length, pull] = edges(x);
    const Vector6 tension = tensions(stress);
    std::array<Eigen::Matrix3d, 6> of_span;
    for (int e = 0; e < 6; ++e) {
        const core::Vector3 direction = pull[e].normalized();
        of_span[e] = (tangent == Tangent::exact ? tension[e] : std::max(tension[e], 0.0)) * rest_length_[e] /
                     length[e] * (Eigen::Matrix3d::Identity() - direction * direction.transpose());
    }
    return hessian_of_edges(of_span);
}

namespace {

using Gradient = Gradients::Value;
using Eigen::Matrix3d;

Matrix3d matrix(const Gradient &of) {
    return Matrix3d::Map(of.data());
}

Gradient columns(const Matrix3d &of) {
    return Gradient::Map(of.data());
}

/// E = (H + H^T + H^T H) / 2 of H = F - I
Matrix3d green_strain(const Matrix3d &h) {
    return 0.5 * (h + h.transpose() + h.transpose() * h);
}

} // namespace

Gradients::Gradients(const std::array<int, 4> &nodes, const Eigen::VectorXd &rest) : nodes_(nodes) {
    const auto [volume, gradient] = volume_gradient(rest, nodes);
    for (int a = 0; a < 4; ++a) {
        rest_[a] = of_node(rest, nodes[a]);
        gradient_[a] = gradient[a] / volume;
    }
}

Gradient Gradients::of(const Eigen::VectorXd &x) const {
    Matrix3d h = Matrix3d::Zero();
    const core::Vector3 origin = of_node(x, nodes_[0]) - rest_[0];
    for (int a = 1; a < 4; ++a)
        h += (of_node(x, nodes_[a]) - rest_[a] - origin) * gradient_[a].transpose();
    return columns(h);
}

Gradient Gradients::rate(const Eigen::VectorXd & /*x*/, const Eigen::VectorXd &u) const {
    Matrix3d h = Matrix3d::Zero();
    for (int a = 0; a < 4; ++a)
        h += of_node(u, nodes_[a]) * gradient_[a].transpose();
    return columns(h);
}

Eigen::Matrix<double, 9, 12> Gradients::slope(const Eigen::VectorXd & /*x*/) const {
    Eigen::Matrix<double, 9, 12> slopes = Eigen::Matrix<double, 9, 12>::Zero();
    for (int a = 0; a < 4; ++a)
        for (int c = 0; c < 3; ++c)
            slopes.block<3, 3>(3 * c, 3 * a) = gradient_[a][c] * Matrix3d::Identity();
    return slopes;
}

void Gradients::add_force(const Eigen::VectorXd & /*x*/, const Value &stress, Eigen::VectorXd &force) const {
    const Matrix3d p = matrix(stress);
    for (int a = 0; a < 4; ++a)
        of_node(force, nodes_[a]) -= p * gradient_[a];
}

double Gradients::energy(const MeanLaw &law, const Value &mean) {
    const Matrix3d h = matrix(mean);
    if (!((Matrix3d::Identity() + h).determinant() > 0.0))
        return std::numeric_limits<double>::infinity();
    return law.energy(green_strain(h));
}

/// P = F S
Gradient Gradients::stress(const MeanLaw &law, const Value &mean) {
    const Matrix3d h = matrix(mean);
    return columns((Matrix3d::Identity() + h) * law.stress(green_strain(h)));
}

Matrix3d Gradients::strain(const Value &mean) {
    return green_strain(matrix(mean));
}

Gradient Gradients::push(const Value &mean, const Vector6 &stress) {
    return columns((Matrix3d::Identity() + matrix(mean)) * tensor(stress));
}

/// dP = F (D : sym(F^T dF)) + dF S
Gradients::Stiffness Gradients::stiffness(const MeanLaw &law, const Value &mean, Tangent tangent) {
    const Matrix3d h = matrix(mean), f = Matrix3d::Identity() + h, strain = green_strain(h);
    Eigen::Matrix<double, 6, 9> strain_slope;
    for (int k = 0; k < 9; ++k) {
        const Matrix3d product = f.transpose() * matrix(Gradient::Unit(k));
        strain_slope.col(k) = components(0.5 * (product + product.transpose()));
    }
    const Matrix6 moduli = tangent == Tangent::material ? law.stiffness_at_rest() : law.stiffness(strain);
    Stiffness result = strain_slope.transpose() * moduli * strain_slope;
    if (tangent == Tangent::material)
        return result;
    const Matrix3d stress = law.stress(strain);
    for (int k = 0; k < 9; ++k)
        result.col(k) += columns(matrix(Gradient::Unit(k)) * stress);
    return tangent == Tangent::exact ? result : core::semi_definite_part(result);
}

namespace {

/// What is shared between the tetrahedra of a kind of parts: nodes, edges, or nothing.
class PartsOfOneKind {
  public:
    PartsOfOneKind(const core::Body &body, double weight, int first_part)
        : body_(body), weight_(weight), first_part_(first_part) {}

    /// @param places  numbers of the nodes or edges of the tetrahedron, each with an equal share
    void add(int tetrahedron, std::span<const int> places, double volume) {
        for (const int place : places) {
            const int region = body_.mesh.region[tetrahedron];
            const auto [at, is_new] = number_.try_emplace({place, region}, static_cast<int>(volume_.size()));
            if (is_new) {
                volume_.push_back(0.0);
                region_.push_back(region);
            }
            volume_[at->second] += volume / static_cast<double>(places.size());
            part_.push_back(at->second);
        }
    }

    int part(int tetrahedron, int place, int num_places) const { return part_[tetrahedron * num_places + place]; }

    void append_to(MeanParts &parts) const {
        for (std::size_t c = 0; c < volume_.size(); ++c) {
            parts.volume.push_back(weight_ * volume_[c]);
            parts.modulus.push_back(body_.materials[region_[c]].shear_modulus());
        }
    }

    int first_part() const { return first_part_; }
    double weight() const { return weight_; }
    double volume_of(int part) const { return volume_[part]; }

  private:
    const core::Body &body_;
    double weight_;
    int first_part_;
    std::map<std::pair<int, int>, int> number_; // of each place and region
    std::vector<double> volume_;
    std::vector<int> region_, part_;
};

} // namespace

MeanParts mean_parts(const core::Body &body, const StrainDomains &domains) {
    const auto &mesh = body.mesh;
    const auto volumes = core::tetrahedron_volumes(mesh);
    MeanParts parts;
    struct Kind {
        PartsOfOneKind parts;
        int num_places;
    };
    std::vector<Kind> kinds;
    const auto add_kind = [&](double weight, int num_places, const auto &places_of) {
        if (weight == 0.0)
            return;
        PartsOfOneKind kind(body, weight, parts.num_parts());
        for (int t = 0; t < mesh.num_tetrahedra(); ++t)
            kind.add(t, places_of(t), volumes[t]);
        kind.append_to(parts);
        kinds.push_back({std::move(kind), num_places});
    };
    add_kind(domains.nodes, 4, [&](int t) { return std::span<const int>(mesh.tetrahedra[t]); });
    const auto edges = domains.edges > 0.0 ? core::edge_table(mesh.tetrahedra) : core::EdgeTable{};
    add_kind(domains.edges, 6, [&](int t) { return std::span<const int>(edges.tetrahedron_edge[t]); });
    std::array<int, 1> itself{};
    add_kind(domains.tetrahedra, 1, [&](int t) {
        itself[0] = t;
        return std::span<const int>(itself);
    });
    parts.start.push_back(0);
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        for (const auto &[kind, num_places] : kinds)
            for (int k = 0; k < num_places; ++k) {
                const int part = kind.part(t, k, num_places);
                parts.members.push_back({.part = kind.first_part() + part,
                                         .of_tetrahedron = kind.weight() / num_places,
                                         .in_mean = volumes[t] / (num_places * kind.volume_of(part))});
            }
        parts.start.push_back(static_cast<int>(parts.members.size()));
    }
    return parts;
}

} // namespace livermark::msm
