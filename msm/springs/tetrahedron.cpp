#include "msm/springs/tetrahedron.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/semi_definite_part.hpp"
#include "msm/spring_energy.hpp"

namespace livermark::msm {

namespace {

/// The matrix of a x .
Eigen::Matrix3d cross_matrix(const core::Vector3 &a) {
    return (Eigen::Matrix3d() << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0).finished();
}

} // namespace

Matrix12 volume_hessian(const Eigen::VectorXd &x, const std::array<int, 4> &tetrahedron) {
    const auto edges = spans_from_first(x, tetrahedron);
    Matrix12 hessian = Matrix12::Zero();
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
               const Matrix12 &block) {
    for (int row = 0; row < 12; ++row)
        for (int column = 0; column < 12; ++column)
            entries.emplace_back(3 * tetrahedron[row / 3] + row % 3, 3 * tetrahedron[column / 3] + column % 3,
                                 block(row, column));
}

Eigen::SparseMatrix<double> square_matrix(const std::vector<Eigen::Triplet<double>> &entries, Eigen::Index size) {
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

EdgeVectors edge_spans(const std::array<int, 4> &nodes, const Eigen::VectorXd &field) {
    EdgeVectors spans;
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        spans[e] = node_part(field, nodes[j]) - node_part(field, nodes[i]);
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
        node_part(force, nodes[i]) += tension[e] * pulls[e];
        node_part(force, nodes[j]) -= tension[e] * pulls[e];
    }
}

Matrix12 hessian_of_edges(const std::array<Eigen::Matrix3d, 6> &second) {
    Matrix12 hessian = Matrix12::Zero();
    for (int e = 0; e < 6; ++e) {
        const auto [i, j] = core::tetrahedron_edges[e];
        hessian.block<3, 3>(3 * i, 3 * i) += second[e];
        hessian.block<3, 3>(3 * j, 3 * j) += second[e];
        hessian.block<3, 3>(3 * i, 3 * j) -= second[e];
        hessian.block<3, 3>(3 * j, 3 * i) -= second[e];
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

Eigen::SparseMatrix<double> stiffness_of_softer_volume(const core::Body &body, double part) {
    // At Poisson's ratio 0.45, lambda = 9 mu, nodal_springs take 49 and 53 steps with 2.5 mu, 62 and 67 with 12 mu; at
    // 0.49, 49 mu, they do not come to an end within 120 with 2.5 mu, and take 100 and 104 with 12 mu.
    constexpr double usual = 2.5, nearly_incompressible = 12.0, limit = 10.0;
    const auto rest = to_unknowns(body.mesh.points);
    return sum_of_blocks(body.mesh.tetrahedra, rest.size(), [&](std::size_t t) -> Matrix12 {
        auto material = body.material_of(t);
        const double mu = material.shear_modulus();
        const double ratio = material.lame_lambda() > limit * mu ? nearly_incompressible : usual;
        const double lambda = std::min(material.lame_lambda(), ratio * mu);
        material.poisson_ratio = 0.5 * lambda / (lambda + mu);
        material.young_modulus = 2.0 * mu * (1.0 + material.poisson_ratio);
        const auto &nodes = body.mesh.tetrahedra[t];
        const double volume = volume_gradient(rest, nodes).volume, softer = material.shear_modulus();
        const Matrix6 strain = strain_of_stretches(rest, nodes);
        const Matrix6 stiffness = isotropic_stiffness(material.lame_lambda(), softer) -
                                  (1.0 - part) * isotropic_stiffness(-2.0 / 3.0 * softer, softer);
        const Matrix6 coupling = 4.0 * volume * strain.transpose() * stiffness * strain;
        const auto slope = stretch_slopes(edge_spans(nodes, rest));
        return 0.25 * slope * coupling * slope.transpose();
    });
}

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
    std::array<Eigen::Matrix3d, 6> second;
    for (int e = 0; e < 6; ++e)
        second[e] = (tangent == Tangent::exact ? tension[e] : std::max(tension[e], 0.0)) * Eigen::Matrix3d::Identity();
    return hessian_of_edges(second);
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
    std::array<Eigen::Matrix3d, 6> second;
    for (int e = 0; e < 6; ++e) {
        const core::Vector3 direction = pull[e].normalized();
        second[e] = (tangent == Tangent::exact ? tension[e] : std::max(tension[e], 0.0)) * rest_length_[e] / length[e] *
                    (Eigen::Matrix3d::Identity() - direction * direction.transpose());
    }
    return hessian_of_edges(second);
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
        rest_[a] = node_part(rest, nodes[a]);
        gradient_[a] = gradient[a] / volume;
    }
}

Gradient Gradients::of(const Eigen::VectorXd &x) const {
    Matrix3d h = Matrix3d::Zero();
    const core::Vector3 origin = node_part(x, nodes_[0]) - rest_[0];
    for (int a = 1; a < 4; ++a)
        h += (node_part(x, nodes_[a]) - rest_[a] - origin) * gradient_[a].transpose();
    return columns(h);
}

Gradient Gradients::rate(const Eigen::VectorXd & /*x*/, const Eigen::VectorXd &u) const {
    Matrix3d h = Matrix3d::Zero();
    for (int a = 0; a < 4; ++a)
        h += node_part(u, nodes_[a]) * gradient_[a].transpose();
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
        node_part(force, nodes_[a]) -= p * gradient_[a];
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

} // namespace livermark::msm
