#include "benchmarks/peers/bullet_scene.hpp"

#include <BulletSoftBody/btDeformableMassSpringForce.h>

namespace livermark::benchmarks::peers {

namespace {

constexpr const char *integrator = "symplectic_euler";

Run make(const Scene &scene, double time_step) {
    const auto softened = with_mean_stiffness(scene);
    auto law =
        std::make_unique<btDeformableMassSpringForce>(static_cast<btScalar>(softened.springs.stiffness[0]), 0.0F);
    return run_springs(std::make_shared<BulletDeformable>(nodes_of(softened), std::move(law), BulletIterations{}),
                       softened, 1.0, time_step);
}

/// Single precision, of which a coordinate takes more digits than the motion: 1e-4 to 6e-4 were seen.
constexpr double tolerance = 2e-3;

} // namespace

Competitor bullet_deformable() {
    Method method;
    method.integrator = integrator;
    method.critical_time_step = [](const Scene &scene) {
        return critical_time_step(with_mean_stiffness(scene), integrator);
    };
    method.make = make;
    method.check = [](const Scene &scene, double time_step, Run &run) {
        const auto softened = with_mean_stiffness(scene);
        return differs_from_oracle(softened, softened.springs, integrator, time_step, run, tolerance);
    };
    return {.summary =
                "Bullet's btDeformable springs, explicit, the whole step of its world; all of the mean stiffness",
            .source = "Coumans, Han and others, Bullet 3.24",
            .methods = {method}};
}

} // namespace livermark::benchmarks::peers
