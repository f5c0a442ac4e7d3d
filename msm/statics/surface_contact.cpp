#include "msm/statics/surface_contact.hpp"

#include <algorithm>
#include <cmath>

#include "core/tool/round_load.hpp"

namespace livermark::msm {

namespace {

/// Of the tetrahedra, weighted with their volumes [Pa].
double mean_young_modulus(const core::Body &body) {
    const auto volumes = tetrahedron_volumes(body.mesh);
    double sum = 0.0, volume = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        sum += volumes[t] * body.materials[body.mesh.region[t]].young_modulus;
        volume += volumes[t];
    }
    return sum / volume;
}

} // namespace

SurfaceContact::SurfaceContact(const core::Problem &problem, double stiffness) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    num_nodes_ = mesh.points.size();
    if (!load_case.touching)
        return;
    ball_ = *load_case.touching;
    std::vector<double> area(mesh.points.size(), 0.0);
    double edges = 0.0;
    int num_edges = 0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (!load_case.may_touch(f))
            continue;
        const auto corners = core::corners_of(mesh, f);
        const double third = area_vector(mesh, f).norm() / 3.0;
        for (std::size_t k = 0; k < 3; ++k) {
            area[mesh.boundary_triangles[f][k]] += third;
            edges += (corners[k] - corners[(k + 1) % 3]).norm();
            ++num_edges;
        }
    }
    law_.penalty = law_.tangential_penalty =
        num_edges > 0 ? stiffness * mean_young_modulus(*problem.body) * num_edges / edges : 1.0;
    law_.friction = ball_.friction;
    centre_ = ball_.start;
    for (std::size_t node = 0; node < area.size(); ++node)
        if (area[node] > 0.0)
            nodes_.push_back({.node = static_cast<int>(node),
                              .area = area[node],
                              .memory = {.multiplier = 0.0, .anchor = mesh.points[node] - centre_}});
}

void SurfaceContact::move_ball(double part) {
    centre_ = ball_.centre_at(part);
}

core::Vector3 SurfaceContact::from_centre(const Node &node, const std::vector<core::Vector3> &positions) const {
    return positions[node.node] - centre_;
}

/// Without its friction.
core::Contact SurfaceContact::normal_contact(const Node &node, const core::Vector3 &from_centre) const {
    auto frictionless = law_;
    frictionless.friction = 0.0;
    return core::touch(frictionless, ball_.radius, from_centre, node.memory);
}

SurfaceContact::Friction SurfaceContact::friction(const Node &node, const core::Vector3 &from_centre) const {
    Friction friction;
    if (node.bound == 0.0)
        return friction;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - node.normal * node.normal.transpose();
    const core::Vector3 slip = across * (from_centre - node.memory.anchor);
    const double size = slip.norm(), eps = law_.tangential_penalty;
    if (eps * size <= node.bound) {
        friction.energy = 0.5 * eps * size * size;
        friction.traction = -eps * slip;
        friction.stiffness = eps * across;
        return friction;
    }
    const core::Vector3 direction = slip / size;
    friction.energy = node.bound * size - 0.5 * node.bound * node.bound / eps;
    friction.traction = -node.bound * direction;
    friction.stiffness = node.bound / size * (across - direction * direction.transpose());
    return friction;
}

double SurfaceContact::energy(const std::vector<core::Vector3> &positions) const {
    double energy = 0.0;
    for (const auto &node : nodes_) {
        const auto d = from_centre(node, positions);
        energy +=
            node.area * (core::contact_energy(law_, normal_contact(node, d), node.memory) + friction(node, d).energy);
    }
    return energy;
}

void SurfaceContact::add_gradient(const std::vector<core::Vector3> &positions,
                                  std::vector<core::Vector3> &gradient) const {
    for (const auto &node : nodes_) {
        const auto d = from_centre(node, positions);
        gradient[node.node] -= node.area * (normal_contact(node, d).traction() + friction(node, d).traction);
    }
}

Eigen::Matrix3d SurfaceContact::block(const Node &node, const core::Vector3 &from_centre, Tangent tangent) const {
    auto frictionless = law_;
    frictionless.friction = 0.0;
    const auto contact = normal_contact(node, from_centre);
    const auto pressure = core::contact_stiffness(frictionless, from_centre, node.memory, contact);
    const Eigen::Matrix3d normal = tangent == Tangent::exact ? pressure.all() : pressure.positive;
    return node.area * (normal + friction(node, from_centre).stiffness);
}

Eigen::SparseMatrix<double> SurfaceContact::hessian(const std::vector<core::Vector3> &positions,
                                                    Tangent tangent) const {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(9 * nodes_.size());
    for (const auto &node : nodes_) {
        const auto of_node = block(node, from_centre(node, positions), tangent);
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
                entries.emplace_back(3 * node.node + r, 3 * node.node + c, of_node(r, c));
    }
    const auto size = static_cast<Eigen::Index>(3 * num_nodes_);
    Eigen::SparseMatrix<double> hessian(size, size);
    hessian.setFromTriplets(entries.begin(), entries.end());
    return hessian;
}

void SurfaceContact::add_hessian_product(const std::vector<core::Vector3> &positions, const Eigen::VectorXd &u,
                                         Eigen::VectorXd &product) const {
    for (const auto &node : nodes_)
        of_node(product, node.node) +=
            block(node, from_centre(node, positions), Tangent::exact) * of_node(u, node.node);
}

double SurfaceContact::update(const std::vector<core::Vector3> &positions, double part) {
    double change = 0.0, all = 0.0;
    for (auto &node : nodes_) {
        const auto d = from_centre(node, positions);
        const core::Vector3 before = node.area * (normal_contact(node, d).traction() + friction(node, d).traction);
        const auto contact = normal_contact(node, d);
        const double was = node.memory.multiplier, bound_was = node.bound;
        node.memory.multiplier = contact.pressure;
        node.normal = contact.gap.normal;
        node.bound = law_.friction * contact.pressure;
        const core::Vector3 along = friction(node, d).traction;
        const core::Vector3 after = node.area * (contact.pressure * contact.gap.normal + along);
        change += node.area * std::abs(contact.pressure - was) + (after - before).norm();
        all += after.norm();
        node.bound = bound_was + part * (node.bound - bound_was);
    }
    return all > 0.0 ? change / all : change > 0.0 ? 1.0 : 0.0;
}

void SurfaceContact::end_step(const std::vector<core::Vector3> &positions) {
    for (auto &node : nodes_) {
        const auto d = from_centre(node, positions);
        node.memory = core::after_step(law_, d, node.memory, core::touch(law_, ball_.radius, d, node.memory));
    }
}

core::Vector3 SurfaceContact::force(const std::vector<core::Vector3> &positions) const {
    core::Vector3 sum = core::Vector3::Zero();
    for (const auto &node : nodes_) {
        const auto d = from_centre(node, positions);
        sum += node.area * (normal_contact(node, d).traction() + friction(node, d).traction);
    }
    return sum;
}

double SurfaceContact::depth(const std::vector<core::Vector3> &positions) const {
    double deepest = 0.0;
    for (const auto &node : nodes_)
        deepest = std::max(deepest, -core::gap_to(ball_.radius, from_centre(node, positions)).size);
    return deepest;
}

} // namespace livermark::msm
