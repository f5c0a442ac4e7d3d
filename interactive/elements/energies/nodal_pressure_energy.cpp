#include "interactive/elements/energies/nodal_pressure_energy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "interactive/elements/energies/element_energy.hpp"

namespace livermark::interactive {

namespace {

/// What of the law stays in the tetrahedra.
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
                auto &of_node = slope.try_emplace(tetrahedra_[t].nodes[c], core::Vector3::Zero()).first->second;
                of_node += 0.25 * slopes[t].col(c);
            }
        const auto node = static_cast<Eigen::Index>(a);
        double curvature = node_lambda_[node] * (1.0 - std::log(jacobians[node])) /
                           (jacobians[node] * jacobians[node] * node_volume_[node]);
        if (is_projected)
            curvature = std::max(curvature, 0.0);
        for (const auto &[i, of_i] : slope)
            for (const auto &[j, of_j] : slope)
                for (int k = 0; k < 3; ++k)
                    for (int l = 0; l < 3; ++l)
                        triplets.emplace_back(3 * i + k, 3 * j + l, curvature * of_i[k] * of_j[l]);
    }
}

} // namespace livermark::interactive
