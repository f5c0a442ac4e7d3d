#include "msm/dynamics/mass_scaling.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "msm/dynamics/highest_frequency.hpp"

namespace livermark::msm {

namespace {

/// Of squared speeds of sound: steps get shorter by the root of it.
constexpr double least_contrast = 2.0;
/// As few nodes do not deform.
constexpr std::size_t least_nodes = 4;

double squared_speed(const core::Material &material) {
    return (material.lame_lambda() + 2.0 * material.shear_modulus()) / material.density;
}

/// (R) whether a region is stiffer than the largest one.
std::vector<bool> stiff_regions(const core::Body &body) {
    std::vector<double> volume(body.materials.size(), 0.0);
    const auto of_tetrahedron = core::tetrahedron_volumes(body.mesh);
    for (std::size_t t = 0; t < of_tetrahedron.size(); ++t)
        volume[body.mesh.region[t]] += of_tetrahedron[t];
    const auto largest = std::ranges::max_element(volume) - volume.begin();
    std::vector<bool> are_stiff;
    for (const auto &material : body.materials)
        are_stiff.push_back(squared_speed(material) > least_contrast * squared_speed(body.materials[largest]));
    return are_stiff;
}

/// The same body with the other nodes constrained as well.
NodalConditions with_these_free(NodalConditions conditions, const std::vector<bool> &are_free) {
    for (std::size_t i = 0; i < are_free.size(); ++i)
        if (!are_free[i])
            conditions.displacement[i].setZero();
    return conditions;
}

} // namespace

std::vector<std::vector<int>> stiff_parts(const core::Body &body) {
    const auto are_stiff = stiff_regions(body);
    std::vector<int> parent(body.mesh.points.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int node) {
        while (parent[node] != node)
            node = parent[node] = parent[parent[node]];
        return node;
    };
    std::vector<bool> is_member(parent.size(), false);
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t)
        if (are_stiff[body.mesh.region[t]])
            for (const int node : body.mesh.tetrahedra[t]) {
                is_member[node] = true;
                parent[root(node)] = root(body.mesh.tetrahedra[t][0]);
            }
    std::map<int, std::vector<int>> nodes_of_root;
    for (std::size_t i = 0; i < parent.size(); ++i)
        if (is_member[i])
            nodes_of_root[root(static_cast<int>(i))].push_back(static_cast<int>(i));
    std::vector<std::vector<int>> parts;
    for (auto &[of_root, nodes] : nodes_of_root)
        parts.push_back(std::move(nodes));
    std::ranges::sort(parts);
    return parts;
}

MassScaling constrained(const MassScaling &scaling, const NodalConditions &conditions) {
    MassScaling result;
    for (auto part : scaling.parts) {
        std::erase_if(part.nodes, [&](int node) { return !conditions.displacement[node].array().isNaN().all(); });
        if (part.nodes.size() >= least_nodes)
            result.parts.push_back(std::move(part));
    }
    return result;
}

MassScaling scale_masses(const core::Body &body, const ElasticBody &springs, const NodalConditions &conditions) {
    const auto &points = body.mesh.points;
    MassScaling scaling;
    for (auto &nodes : stiff_parts(body))
        scaling.parts.push_back({.nodes = std::move(nodes)});
    scaling = constrained(scaling, conditions);
    std::vector<bool> is_rest(points.size(), true);
    for (const auto &part : scaling.parts)
        for (const int node : part.nodes)
            is_rest[node] = false;
    const double of_rest =
        scaling.parts.empty() ? 0.0 : largest_angular_frequency(springs, points, with_these_free(conditions, is_rest));
    if (!(of_rest > 0.0))
        return {}; // no tissue to be as slow as
    for (auto &part : scaling.parts) {
        std::vector<bool> is_free(points.size(), false);
        for (const int node : part.nodes)
            is_free[node] = true;
        const double of_part = largest_angular_frequency(springs, points, with_these_free(conditions, is_free));
        part.factor = of_part * of_part / (of_rest * of_rest);
    }
    std::erase_if(scaling.parts, [](const HeavyPart &part) { return !(part.factor > 1.0); });
    return scaling;
}

void scale_deformation(const Eigen::VectorXd &mass, const Eigen::Matrix3Xd &x, double factor, Eigen::Matrix3Xd &field) {
    const double total = mass.sum();
    const Eigen::Vector3d centre = x * mass / total, mean = field * mass / total;
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero(); // moments
    Eigen::Vector3d spin = Eigen::Vector3d::Zero();   // angular momentum about the centre
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
        const Eigen::Vector3d arm = x.col(i) - centre, weighted = mass[i] * arm;
        second += weighted * arm.transpose();
        spin += weighted.cross(field.col(i));
    }
    const Eigen::Matrix3d inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
    const Eigen::Vector3d rotation = inertia.inverse() * spin;
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
        const Eigen::Vector3d rigid = mean + rotation.cross(x.col(i) - centre);
        field.col(i) = rigid + factor * (field.col(i) - rigid);
    }
}

void scale_deformation(const MassScaling &scaling, double power, const std::vector<double> &node_mass,
                       const Eigen::VectorXd &x, Eigen::VectorXd &field) {
    for (const auto &[nodes, factor] : scaling.parts) {
        const auto size = static_cast<Eigen::Index>(nodes.size());
        Eigen::VectorXd mass(size);
        Eigen::Matrix3Xd there(3, size), of_part(3, size);
        for (Eigen::Index i = 0; i < size; ++i) {
            mass[i] = node_mass[nodes[i]];
            there.col(i) = of_node(x, nodes[i]);
            of_part.col(i) = of_node(field, nodes[i]);
        }
        scale_deformation(mass, there, std::pow(factor, power), of_part);
        for (Eigen::Index i = 0; i < size; ++i)
            of_node(field, nodes[i]) = of_part.col(i);
    }
}

} // namespace livermark::msm
