#include "benchmarks/peers/bullet_scene.hpp"

namespace livermark::benchmarks::peers {

namespace {

/// Part of each link's fault that a pass over the links takes away, of Bullet's [0, 1]. At 1, its default, the
/// velocities that come out of the passes blow liver_refined_once up within 40 steps, however short; it takes no other
/// time.
constexpr double link_stiffness = 0.5;

/// Positions after one step from rest: a pass over the links, in their order, that moves both ends of each along it by
/// shares of their inverse masses until a part of the fault of its squared length is gone, to first order.
/// (Jakobsen 2001, Advanced character physics, Game Developers Conference)
std::vector<core::Vector3> relaxed(const Scene &scene) {
    auto x = scene.start;
    const auto &springs = scene.springs;
    const auto inverse_mass = [&](int i) { return scene.is_constrained[i] ? 0.0 : 1.0 / springs.node_mass[i]; };
    for (std::size_t s = 0; s < springs.edges.size(); ++s) {
        const auto [i, j] = springs.edges[s];
        const double sum = inverse_mass(i) + inverse_mass(j);
        if (sum == 0.0)
            continue;
        const core::Vector3 span = x[j] - x[i];
        const double wanted = springs.rest_length[s] * springs.rest_length[s], is = span.squaredNorm();
        const core::Vector3 correction = link_stiffness * (wanted - is) / (sum * (wanted + is)) * span;
        x[i] -= inverse_mass(i) * correction;
        x[j] += inverse_mass(j) * correction;
    }
    return x;
}

/// Single precision, of which a coordinate takes more digits than the motion: 2e-4 to 5e-4 were seen.
constexpr double tolerance = 2e-3;

Run make(const Scene &scene, double time_step) {
    return run_springs(std::make_shared<BulletPositionBased>(nodes_of(scene), 1), scene, link_stiffness, time_step);
}

} // namespace

Competitor bullet_soft_body() {
    Method method;
    method.integrator = "position_based";
    method.critical_time_step = [](const Scene &) { return std::numeric_limits<double>::infinity(); };
    method.make = make;
    method.check = [](const Scene &scene, double, Run &run) {
        run.step();
        return differs_from(relaxed(scene), scene, run, tolerance);
    };
    return {.summary = "Bullet's btSoftBody: links made as long as they should be one after the other, once per step; "
                       "stiffness comes from the step",
            .source = "Coumans and others, Bullet 3.24",
            .methods = {method}};
}

} // namespace livermark::benchmarks::peers
