#include "interactive/elements/energies.hpp"

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "core/semi_definite_part.hpp"

namespace livermark::interactive {

std::vector<Tetrahedron> tetrahedra_at_rest(const core::Body &body) {
    std::vector<Tetrahedron> result;
    result.reserve(body.mesh.tetrahedra.size());
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t) {
        const auto &nodes = body.mesh.tetrahedra[t];
        const auto material = body.material_of(t);
        Matrix3 edges;
        for (int c = 0; c < 3; ++c)
            edges.col(c) = body.mesh.points[nodes[c + 1]] - body.mesh.points[nodes[0]];
        result.push_back({.nodes = nodes,
                          .inverse_edges = edges.inverse(),
                          .volume = edges.determinant() / 6.0,
                          .mu = material.shear_modulus(),
                          .lambda = material.lame_lambda()});
    }
    return result;
}

} // namespace livermark::interactive

// What Newton's method alone calls: it takes seconds to compile, and each method includes the header.
namespace livermark::interactive::densities {

Tangent determinant_tangent(const Matrix3 &f) {
    Tangent result = Tangent::Zero();
    for (int c = 0; c < 3; ++c) { // cofactor column c is the product of the next two columns of F
        const int a = (c + 1) % 3, b = (c + 2) % 3;
        const auto cross = [](const core::Vector3 &v) {
            Matrix3 m;
            m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
            return m;
        };
        result.block<3, 3>(3 * c, 3 * b) += cross(f.col(a));
        result.block<3, 3>(3 * c, 3 * a) -= cross(f.col(b));
    }
    return result;
}

Tangent semi_definite_part(const Tangent &tangent) {
    return core::semi_definite_part(tangent);
}

Matrix3 nearest_rotation(const Matrix3 &f) {
    const Eigen::JacobiSVD<Matrix3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3 u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0.0)
        u.col(2) = -u.col(2);
    return u * svd.matrixV().transpose();
}

// dR = R [w], (tr S - S) w = axial vector of R^T dF.
Tangent Corotational::tangent(const Matrix3 &f) const {
    const Matrix3 r = rotation(f);
    const Matrix3 s = r.transpose() * f;
    const Matrix3 spin = (s.trace() * Matrix3::Identity() - s).inverse();
    Tangent result = 2.0 * mu * Tangent::Identity() + lambda * by_columns(r) * by_columns(r).transpose();
    for (int k = 0; k < 9; ++k) {
        Matrix3 df = Matrix3::Zero();
        df.data()[k] = 1.0;
        const Matrix3 turned = r.transpose() * df;
        const core::Vector3 w =
            spin * core::Vector3(turned(2, 1) - turned(1, 2), turned(0, 2) - turned(2, 0), turned(1, 0) - turned(0, 1));
        Matrix3 cross;
        cross << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
        result.col(k) += (lambda * (s.trace() - 3.0) - 2.0 * mu) * by_columns(r * cross);
    }
    return result;
}

Tangent NeoHookean::tangent(const Matrix3 &f) const {
    const double jacobian = f.determinant();
    const double log = std::log(jacobian);
    const auto c = by_columns(cofactors(f));
    return mu * Tangent::Identity() + (lambda * (1.0 - log) + mu) / (jacobian * jacobian) * c * c.transpose() +
           (lambda * log - mu) / jacobian * determinant_tangent(f);
}

Tangent StableNeoHookean::tangent(const Matrix3 &f) const {
    const auto c = by_columns(cofactors(f));
    return mu * Tangent::Identity() + (lambda + mu) * c * c.transpose() +
           ((lambda + mu) * (f.determinant() - 1.0) - mu) * determinant_tangent(f);
}

} // namespace livermark::interactive::densities

namespace livermark::interactive {

void add_tangent(const Tetrahedron &tetrahedron, const densities::Tangent &tangent, Energy::Triplets &triplets) {
    const auto gradients = tetrahedron.shape_gradients();
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) {
            Matrix3 block = Matrix3::Zero();
            for (int j = 0; j < 3; ++j)
                for (int l = 0; l < 3; ++l)
                    block += gradients(a, j) * gradients(b, l) * tangent.block<3, 3>(3 * j, 3 * l);
            block *= tetrahedron.volume;
            for (int i = 0; i < 3; ++i)
                for (int k = 0; k < 3; ++k)
                    triplets.emplace_back(3 * tetrahedron.nodes[a] + i, 3 * tetrahedron.nodes[b] + k, block(i, k));
        }
}

namespace {

/// The part of the law that stays in the tetrahedra.
densities::NeoHookean local_density(const Tetrahedron &tetrahedron) {
    return {tetrahedron.mu, 0.0};
}

} // namespace

NodalPressureEnergy::NodalPressureEnergy(const core::Body &body)
    : tetrahedra_(tetrahedra_at_rest(body)), around_(body.mesh.points.size()),
      node_volume_(Eigen::VectorXd::Zero(body.mesh.num_nodes())), node_lambda_(node_volume_) {
    for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
        for (const int node : tetrahedra_[t].nodes) {
            around_[node].push_back(static_cast<int>(t));
            node_volume_[node] += 0.25 * tetrahedra_[t].volume;
            node_lambda_[node] += 0.25 * tetrahedra_[t].volume * tetrahedra_[t].lambda;
        }
    node_lambda_ = node_lambda_.cwiseQuotient(node_volume_);
}

Eigen::VectorXd NodalPressureEnergy::nodal_jacobians(const Field &x) const {
    Eigen::VectorXd jacobians = Eigen::VectorXd::Zero(node_volume_.size());
    for (const auto &t : tetrahedra_) {
        const double quarter = 0.25 * t.volume * t.gradient(x).determinant();
        for (const int node : t.nodes)
            jacobians[node] += quarter;
    }
    return jacobians.cwiseQuotient(node_volume_);
}

Eigen::VectorXd NodalPressureEnergy::nodal_pressures(const Field &x) const {
    const Eigen::ArrayXd jacobians = nodal_jacobians(x);
    return node_lambda_.array() * jacobians.log() / jacobians;
}

double NodalPressureEnergy::mean_pressure(const Tetrahedron &tetrahedron, const Eigen::VectorXd &pressures) const {
    const auto &[a, b, c, d] = tetrahedron.nodes;
    return 0.25 * (pressures[a] + pressures[b] + pressures[c] + pressures[d]);
}

double NodalPressureEnergy::value(const Field &x) const {
    const Eigen::ArrayXd jacobians = nodal_jacobians(x);
    if (!(jacobians > 0.0).all())
        return std::numeric_limits<double>::infinity();
    double value = 0.5 * (node_volume_.array() * node_lambda_.array() * jacobians.log().square()).sum();
    for (const auto &t : tetrahedra_)
        value += t.volume * local_density(t).value(t.gradient(x));
    return value;
}

void NodalPressureEnergy::add_forces(const Field &x, Field &f) const {
    const auto pressures = nodal_pressures(x);
    for (const auto &t : tetrahedra_) {
        const Matrix3 gradient = t.gradient(x);
        t.add_forces(local_density(t).stress(gradient) + mean_pressure(t, pressures) * cofactors(gradient), f);
    }
}

void NodalPressureEnergy::add_hessian(const Field &x, bool is_projected, Triplets &triplets) const {
    const auto jacobians = nodal_jacobians(x);
    const auto pressures = nodal_pressures(x);
    std::vector<Eigen::Matrix<double, 3, 4>> slopes; // V dJ/dx of each tetrahedron at its corners
    for (const auto &t : tetrahedra_) {
        const Matrix3 gradient = t.gradient(x);
        const densities::Tangent tangent =
            local_density(t).tangent(gradient) + mean_pressure(t, pressures) * densities::determinant_tangent(gradient);
        add_tangent(t, is_projected ? densities::semi_definite_part(tangent) : tangent, triplets);
        slopes.emplace_back(t.volume * cofactors(gradient) * t.shape_gradients().transpose());
    }
    for (std::size_t a = 0; a < around_.size(); ++a) {
        std::map<int, core::Vector3> slope; // V_a dJ_a/dx
        for (const int t : around_[a])
            for (int c = 0; c < 4; ++c) {
                auto &node_slope = slope.try_emplace(tetrahedra_[t].nodes[c], core::Vector3::Zero()).first->second;
                node_slope += 0.25 * slopes[t].col(c);
            }
        const auto node = static_cast<Eigen::Index>(a);
        double curvature = node_lambda_[node] * (1.0 - std::log(jacobians[node])) /
                           (jacobians[node] * jacobians[node] * node_volume_[node]);
        if (is_projected)
            curvature = std::max(curvature, 0.0);
        for (const auto &[i, slope_i] : slope)
            for (const auto &[j, slope_j] : slope)
                for (int k = 0; k < 3; ++k)
                    for (int l = 0; l < 3; ++l)
                        triplets.emplace_back(3 * i + k, 3 * j + l, curvature * slope_i[k] * slope_j[l]);
    }
}

} // namespace livermark::interactive

namespace livermark::interactive::densities {

namespace {

core::Vector3 product_slopes(const core::Vector3 &s) {
    return {s.y() * s.z(), s.z() * s.x(), s.x() * s.y()};
}

Matrix3 volume_projection(const Matrix3 &f) {
    const auto [u, v, s] = signed_svd(f);
    return u * nearest_of_unit_product(s).asDiagonal() * v.transpose();
}

/// d p / d s of the nearest point p: p = s + n g with g = d(product)/dp, so dp - n (d2 product) dp - g dn = ds and
/// g . dp = 0.
Matrix3 slope_of_nearest(const core::Vector3 &s, const core::Vector3 &p) {
    const core::Vector3 g = product_slopes(p);
    const double n = (p - s).dot(g) / g.squaredNorm();
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (i != j)
                matrix(i, j) = -n * p[3 - i - j];
    matrix.block<3, 1>(0, 3) = -g;
    matrix.block<1, 3>(3, 0) = g.transpose();
    matrix(3, 3) = 0.0;
    return matrix.inverse().topLeftCorner<3, 3>();
}

/// dD/dF: in the frames of U and V, the diagonal follows the nearest point; the rest turns with them.
Tangent volume_projection_tangent(const Matrix3 &f) {
    constexpr double equal = 1e-6;
    const auto [u, v, s] = signed_svd(f);
    const auto p = nearest_of_unit_product(s);
    const Matrix3 slope = slope_of_nearest(s, p);
    Tangent result;
    for (int k = 0; k < 9; ++k) {
        Matrix3 df = Matrix3::Zero();
        df.data()[k] = 1.0;
        const Matrix3 a = u.transpose() * df * v;
        Matrix3 e;
        e.diagonal() = slope * a.diagonal();
        for (int i = 0; i < 3; ++i)
            for (int j = i + 1; j < 3; ++j) {
                const bool are_equal = std::abs(s[i] - s[j]) < equal;
                const double even = are_equal ? slope(i, i) - slope(i, j) : (p[i] - p[j]) / (s[i] - s[j]);
                const double odd = (p[i] + p[j]) / (s[i] + s[j]);
                e(i, j) = 0.5 * (even * (a(i, j) + a(j, i)) + odd * (a(i, j) - a(j, i)));
                e(j, i) = 0.5 * (even * (a(i, j) + a(j, i)) - odd * (a(i, j) - a(j, i)));
            }
        result.col(k) = by_columns(u * e * v.transpose());
    }
    return result;
}

} // namespace

SignedSvd signed_svd(const Matrix3 &f) {
    const Eigen::JacobiSVD<Matrix3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    SignedSvd result{svd.matrixU(), svd.matrixV(), svd.singularValues()};
    for (Matrix3 *const m : {&result.u, &result.v})
        if (m->determinant() < 0.0) {
            m->col(2) = -m->col(2);
            result.s[2] = -result.s[2];
        }
    return result;
}

core::Vector3 nearest_of_unit_product(const core::Vector3 &s) {
    constexpr int max_iterations = 100;
    constexpr double tolerance = 1e-28; // of squares
    core::Vector3 move = core::Vector3::Zero();
    for (int i = 0; i < max_iterations; ++i) {
        const core::Vector3 p = s + move;
        const core::Vector3 g = product_slopes(p);
        const core::Vector3 next = (g.dot(move) - (p.prod() - 1.0)) / g.squaredNorm() * g;
        const double change = (next - move).squaredNorm();
        move = next;
        if (change < tolerance)
            break;
    }
    return s + move;
}

double Projective::value(const Matrix3 &f) const {
    return mu * (f - nearest_rotation(f)).squaredNorm() + 1.5 * lambda * (f - volume_projection(f)).squaredNorm();
}

Matrix3 Projective::stress(const Matrix3 &f) const {
    return 2.0 * mu * (f - rotation(f)) + 3.0 * lambda * (f - volume_projection(f));
}

Tangent Projective::tangent(const Matrix3 &f) const {
    return Corotational{mu, 0.0}.tangent(f) + 3.0 * lambda * (Tangent::Identity() - volume_projection_tangent(f));
}

} // namespace livermark::interactive::densities

namespace livermark::interactive {

Springs springs_with_shear_modulus(const core::Body &body) {
    return springs_with_shear_modulus(body, core::edge_table(body.mesh.tetrahedra));
}

Springs springs_with_shear_modulus(const core::Body &body, const core::EdgeTable &table) {
    constexpr double factor = 2.0 * std::numbers::sqrt2 / 25.0, young_over_shear = 2.5;
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    Springs springs{table.edges, core::capsule_springs(body, table), {}};
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const double length = std::cbrt(6.0 * std::numbers::sqrt2 * volumes[t]);
        const double young_modulus = young_over_shear * body.shear_modulus_of(t);
        for (const int edge : table.tetrahedron_edge[t])
            springs.stiffness[edge] += factor * length * young_modulus;
    }
    for (const auto &[a, b] : springs.edges)
        springs.rest_length.push_back((body.mesh.points[a] - body.mesh.points[b]).norm());
    return springs;
}

SpringEnergy::SpringEnergy(Springs springs) : springs_(std::move(springs)) {}

double SpringEnergy::value(const Field &x) const {
    double value = 0.0;
    for (std::size_t s = 0; s < springs_.edges.size(); ++s) {
        const auto &[a, b] = springs_.edges[s];
        value += springs_.law(s).value(x.col(a) - x.col(b));
    }
    return value;
}

void SpringEnergy::add_forces(const Field &x, Field &f) const {
    for (std::size_t s = 0; s < springs_.edges.size(); ++s) {
        const auto &[a, b] = springs_.edges[s];
        const core::Vector3 force = springs_.law(s).pull(x.col(a) - x.col(b));
        f.col(a) -= force;
        f.col(b) += force;
    }
}

void SpringEnergy::add_hessian(const Field &x, bool is_projected, Triplets &triplets) const {
    for (std::size_t s = 0; s < springs_.edges.size(); ++s) {
        const auto &edge = springs_.edges[s];
        const Matrix3 block = springs_.law(s).tangent(x.col(edge[0]) - x.col(edge[1]), is_projected);
        for (int a = 0; a < 2; ++a)
            for (int b = 0; b < 2; ++b)
                for (int i = 0; i < 3; ++i)
                    for (int k = 0; k < 3; ++k)
                        triplets.emplace_back(3 * edge[a] + i, 3 * edge[b] + k, (a == b ? 1.0 : -1.0) * block(i, k));
    }
}

SpringAndVolumeEnergy::SpringAndVolumeEnergy(const core::Body &body, const core::EdgeTable &edges)
    : springs_(springs_with_shear_modulus(body, edges)), volumes_(tetrahedra_at_rest(body)) {}

} // namespace livermark::interactive
