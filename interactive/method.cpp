#include "interactive/method.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <stdexcept>
#include <utility>

namespace livermark::interactive {

namespace {

Scene checked(Scene scene) {
    if (static_cast<int>(scene.node_mass.size()) != num_nodes(scene))
        throw std::invalid_argument(
            fmt::format("{} masses for {} nodes; give each node one", scene.node_mass.size(), num_nodes(scene)));
    if (!std::ranges::all_of(scene.node_mass, [](double mass) { return mass > 0.0; }))
        throw std::invalid_argument("a node without mass; every node of a scene has to belong to a tetrahedron");
    if (!(scene.mass_damping >= 0.0))
        throw std::invalid_argument("the damping of a scene is negative; give 0 or more");
    std::set<int> seen;
    const int num_corners = scene.body->mesh.num_nodes();
    for (const int node : scene.constrained_nodes)
        if (node < 0 || node >= num_corners || !seen.insert(node).second)
            throw std::invalid_argument(
                fmt::format("constrained node {} is none of the {} nodes, or there twice", node, num_corners));
    return scene;
}

void check_shape(const Field &field, Eigen::Index columns, const char *what) {
    if (field.cols() != columns)
        throw std::invalid_argument(fmt::format("{} {} where {} are needed", field.cols(), what, columns));
}

} // namespace

int num_nodes(const Scene &scene) {
    return scene.body->mesh.num_nodes() + static_cast<int>(scene.own_nodes.size());
}

Field rest_positions(const Scene &scene) {
    Field x(3, num_nodes(scene));
    Eigen::Index i = 0;
    for (const auto *points : {&scene.body->mesh.points, &scene.own_nodes})
        for (const auto &point : *points)
            x.col(i++) = point;
    return x;
}

std::vector<bool> free_nodes(const Scene &scene) {
    std::vector<bool> is_free(num_nodes(scene), true);
    for (const int node : scene.constrained_nodes)
        is_free[node] = false;
    for (const auto &follower : scene.followers)
        is_free[follower.node] = false;
    return is_free;
}

void put_constrained(const Scene &scene, const Field &targets, Field &x) {
    for (Eigen::Index c = 0; c < targets.cols(); ++c)
        x.col(scene.constrained_nodes[c]) = targets.col(c);
    for (const auto &[node, ends] : scene.followers)
        x.col(node) = 0.5 * (targets.col(ends[0]) + targets.col(ends[1]));
}

Field reactions_to(const Scene &scene, const Field &forces) {
    Field reactions(3, scene.constrained_nodes.size());
    for (Eigen::Index c = 0; c < reactions.cols(); ++c)
        reactions.col(c) = -forces.col(scene.constrained_nodes[c]);
    for (const auto &[node, ends] : scene.followers)
        for (const int end : ends)
            reactions.col(end) -= 0.5 * forces.col(node);
    return reactions;
}

Simulation::Simulation(Scene scene)
    : scene_(checked(std::move(scene))), is_free_(free_nodes(scene_)), x_(rest_positions(scene_)),
      v_(Field::Zero(3, x_.cols())), external_(v_), targets_(3, scene_.constrained_nodes.size()) {
    for (Eigen::Index c = 0; c < targets_.cols(); ++c)
        targets_.col(c) = x_.col(scene_.constrained_nodes[c]);
}

void Simulation::set_external_forces(const Field &forces) {
    const Eigen::Index num_corners = scene_.body->mesh.num_nodes();
    check_shape(forces, forces.cols() == num_corners ? num_corners : x_.cols(), "external forces");
    external_.setZero();
    external_.leftCols(forces.cols()) = forces;
}

void Simulation::set_targets(const Field &positions) {
    check_shape(positions, targets_.cols(), "targets");
    targets_ = positions;
}

void Simulation::set_state(const Field &positions, const Field &velocities) {
    check_shape(positions, x_.cols(), "positions");
    check_shape(velocities, x_.cols(), "velocities");
    x_ = positions;
    v_ = velocities;
}

void Simulation::kick(const Field &velocity, double time_step) {
    check_shape(velocity, x_.cols(), "velocities");
    set_state(x_ + time_step * velocity, v_ + velocity);
}

Orders Simulation::orders() const {
    return {};
}

Field Simulation::elastic_forces() const {
    Field forces = Field::Zero(3, x_.cols());
    energy().add_forces(x_, forces);
    return forces;
}

Field Simulation::reactions() const {
    return reactions_to(scene_, elastic_forces() + external_);
}

void Simulation::move_to_targets() {
    put_constrained(scene_, targets_, x_);
}

const Method &find_method(std::string_view name) {
    const auto table = all_methods();
    const auto found = std::ranges::find(table, name, &Method::name);
    if (found == table.end())
        throw std::invalid_argument(fmt::format("there is no interactive method {}", name));
    return *found;
}

Inertia inertia(const Simulation &simulation, double time_step) {
    const auto &scene = simulation.scene();
    const double damping = 1.0 + scene.mass_damping * time_step;
    const auto &x = simulation.positions();
    Inertia inertia{std::vector<double>(scene.node_mass.size()), Field(3, x.cols())};
    for (Eigen::Index i = 0; i < x.cols(); ++i) {
        const double mass = scene.node_mass[i];
        inertia.stiffness[i] = mass * damping / (time_step * time_step);
        inertia.predicted.col(i) = x.col(i) + (time_step * simulation.velocities().col(i) +
                                               time_step * time_step / mass * simulation.external_forces().col(i)) /
                                                  damping;
    }
    put_constrained(scene, simulation.targets(), inertia.predicted);
    return inertia;
}

} // namespace livermark::interactive
