#include "interactive/simulation.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <stdexcept>
#include <utility>

#include "interactive/method.hpp"

namespace livermark::interactive {

namespace {

Scene checked(Scene scene) {
    const int num_nodes = scene.body->mesh.num_nodes();
    if (static_cast<int>(scene.node_mass.size()) != num_nodes)
        throw std::invalid_argument(
            fmt::format("{} masses for {} nodes; give each node one", scene.node_mass.size(), num_nodes));
    if (!std::ranges::all_of(scene.node_mass, [](double mass) { return mass > 0.0; }))
        throw std::invalid_argument("a node without mass; every node of a scene has to belong to a tetrahedron");
    if (!(scene.mass_damping >= 0.0))
        throw std::invalid_argument("the damping of a scene is negative; give 0 or more");
    std::set<int> seen;
    for (const int node : scene.constrained_nodes)
        if (node < 0 || node >= num_nodes || !seen.insert(node).second)
            throw std::invalid_argument(
                fmt::format("constrained node {} is none of the {} nodes, or there twice", node, num_nodes));
    return scene;
}

void check_shape(const Field &field, Eigen::Index columns, const char *what) {
    if (field.cols() != columns)
        throw std::invalid_argument(fmt::format("{} {} where {} are needed", field.cols(), what, columns));
}

} // namespace

Field rest_positions(const Scene &scene) {
    const auto &points = scene.body->mesh.points;
    Field x(3, points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        x.col(static_cast<Eigen::Index>(i)) = points[i];
    return x;
}

std::vector<bool> free_nodes(const Scene &scene) {
    std::vector<bool> is_free(scene.body->mesh.points.size(), true);
    for (const int node : scene.constrained_nodes)
        is_free[node] = false;
    return is_free;
}

Simulation::Simulation(Scene scene)
    : scene_(checked(std::move(scene))), is_free_(free_nodes(scene_)), x_(rest_positions(scene_)),
      v_(Field::Zero(3, x_.cols())), external_(v_), targets_(3, scene_.constrained_nodes.size()) {
    for (Eigen::Index c = 0; c < targets_.cols(); ++c)
        targets_.col(c) = x_.col(scene_.constrained_nodes[c]);
}

void Simulation::set_external_forces(const Field &forces) {
    check_shape(forces, x_.cols(), "external forces");
    external_ = forces;
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

Field Simulation::elastic_forces() const {
    Field forces = Field::Zero(3, x_.cols());
    energy().add_forces(x_, forces);
    return forces;
}

Field Simulation::reactions() const {
    const Field forces = elastic_forces();
    Field reactions(3, targets_.cols());
    for (Eigen::Index c = 0; c < targets_.cols(); ++c) {
        const int node = scene_.constrained_nodes[c];
        reactions.col(c) = -forces.col(node) - external_.col(node);
    }
    return reactions;
}

void Simulation::move_to_targets() {
    for (Eigen::Index c = 0; c < targets_.cols(); ++c)
        x_.col(scene_.constrained_nodes[c]) = targets_.col(c);
}

const Method &find_method(std::string_view name) {
    const auto table = all_methods();
    const auto found = std::ranges::find(table, name, &Method::name);
    if (found == table.end())
        throw std::invalid_argument(fmt::format("there is no interactive method {}", name));
    return *found;
}

} // namespace livermark::interactive
