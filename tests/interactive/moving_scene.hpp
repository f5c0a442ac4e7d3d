#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <hwy/targets.h>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "interactive/method.hpp"
#include "msm/elastic_body.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

/// A bar of soft tissue of 16 bricks, 60 x 30 x 30 mm.
inline std::shared_ptr<const core::Body> soft_bar(double poisson_ratio = 0.45) {
    return make_body(box_mesh({0.06, 0.03, 0.03}, {4, 2, 2}),
                     {.density = 1060.0, .young_modulus = 5000.0, .poisson_ratio = poisson_ratio});
}

/// A scene of a body that is free or constrained where x = 0.
inline interactive::Scene scene_of(std::shared_ptr<const core::Body> body, bool is_constrained, double mass_damping) {
    interactive::Scene scene{.body = std::move(body), .node_mass = {}, .constrained_nodes = {}};
    scene.node_mass = msm::lumped_masses(*scene.body);
    scene.mass_damping = mass_damping;
    for (int i = 0; is_constrained && i < scene.body->mesh.num_nodes(); ++i)
        if (scene.body->mesh.points[i].x() == 0.0)
            scene.constrained_nodes.push_back(i);
    return scene;
}

inline interactive::Scene bar_scene(bool is_constrained, double poisson_ratio = 0.45, double mass_damping = 0.0) {
    return scene_of(soft_bar(poisson_ratio), is_constrained, mass_damping);
}

inline std::vector<std::string> method_names(const std::function<bool(const interactive::Method &)> &is_wanted = {}) {
    std::vector<std::string> names;
    for (const auto &method : interactive::all_methods())
        if (!is_wanted || is_wanted(method))
            names.push_back(method.name);
    return names;
}

/// Every component is between minus and plus the largest.
inline interactive::Field noise(Eigen::Index num_nodes, double largest, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> component(-largest, largest);
    interactive::Field field(3, num_nodes);
    for (Eigen::Index k = 0; k < field.size(); ++k)
        field.data()[k] = component(random);
    return field;
}

/// Turned by two radians, and elsewhere.
inline interactive::Field turned(const interactive::Field &x) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(2.0, core::Vector3(1.0, -2.0, 0.5).normalized()).matrix();
    return (turn * x).colwise() + core::Vector3(0.1, 0.2, -0.3);
}

/// A bar of two materials, one ten times as hard, whose nodes are at no regular places: 6 nx ny nz tetrahedra, which
/// neither four lanes nor more divide where nx ny nz is odd.
inline interactive::Scene uneven_scene(const std::array<int, 3> &bricks, bool is_constrained,
                                       double mass_damping = 0.0) {
    auto mesh = box_mesh({0.06, 0.03, 0.03}, bricks);
    const double spacing = 0.03 / std::max(bricks[1], bricks[2]);
    const auto shifts = noise(mesh.num_nodes(), 0.1 * spacing, 17);
    for (int i = 0; i < mesh.num_nodes(); ++i)
        if (mesh.points[i].x() != 0.0)
            mesh.points[i] += shifts.col(i);
    mesh.region_names.emplace_back("hard");
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        mesh.region[t] = t % 7 == 0 ? 1 : 0;
    core::Body body{.name = "uneven",
                    .mesh = std::move(mesh),
                    .materials = {{.density = 1060.0, .young_modulus = 5000.0, .poisson_ratio = 0.45},
                                  {.density = 1200.0, .young_modulus = 50000.0, .poisson_ratio = 0.3}}};
    return scene_of(std::make_shared<const core::Body>(std::move(body)), is_constrained, mass_damping);
}

inline std::vector<interactive::Scene> scenes_of_any_padding() {
    std::vector<interactive::Scene> scenes{bar_scene(false), bar_scene(false, 0.49), uneven_scene({1, 1, 1}, false),
                                           uneven_scene({5, 3, 3}, false), uneven_scene({3, 2, 1}, false)};
    scenes.push_back(scene_of(
        make_body(regular_tetrahedron(0.02), {.density = 1060.0, .young_modulus = 5000.0, .poisson_ratio = 0.45}),
        false, 0.0));
    return scenes;
}

inline core::Vector3 momentum_of(const interactive::Simulation &simulation) {
    return simulation.velocities() *
           Eigen::Map<const Eigen::VectorXd>(simulation.scene().node_mass.data(), simulation.velocities().cols());
}

/// Takes one of the vector units of this machine while it is there.
class ChosenVectorUnit {
  public:
    explicit ChosenVectorUnit(std::int64_t target) { choose(target); }
    ~ChosenVectorUnit() { choose(0); }
    ChosenVectorUnit(const ChosenVectorUnit &) = delete;
    ChosenVectorUnit &operator=(const ChosenVectorUnit &) = delete;

    /// Zero stands for the best one.
    static void choose(std::int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
};

} // namespace livermark::tests
