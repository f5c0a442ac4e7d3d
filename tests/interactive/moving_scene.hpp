#pragma once

#include <memory>
#include <random>

#include "interactive/scene.hpp"
#include "msm/mass_lumping.hpp"
#include "tests/test_meshes.hpp"

namespace livermark::tests {

/// A bar of soft tissue of 16 bricks, 60 x 30 x 30 mm.
inline std::shared_ptr<const core::Body> soft_bar(double poisson_ratio = 0.45) {
    return make_body(box_mesh({0.06, 0.03, 0.03}, {4, 2, 2}),
                     {.density = 1060.0, .young_modulus = 5000.0, .poisson_ratio = poisson_ratio});
}

/// The bar, free or with its end at x = 0 constrained, for steps in double precision.
inline interactive::Scene bar_scene(bool is_constrained, double poisson_ratio = 0.45, double mass_damping = 0.0) {
    interactive::Scene scene{.body = soft_bar(poisson_ratio),
                             .node_mass = {},
                             .constrained_nodes = {},
                             .precision = interactive::Precision::double_precision};
    scene.node_mass = msm::lumped_masses(*scene.body);
    scene.mass_damping = mass_damping;
    for (int i = 0; is_constrained && i < scene.body->mesh.num_nodes(); ++i)
        if (scene.body->mesh.points[i].x() == 0.0)
            scene.constrained_nodes.push_back(i);
    return scene;
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

} // namespace livermark::tests
