#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized" // gcc 12 suspects a default argument in Bullet's headers
#endif

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include "benchmarks/peers/bullet_body.hpp"

namespace livermark::benchmarks::peers {

namespace {

constexpr const char *integrator = "symplectic_euler";

/// Parts of a world, in the order in which they are taken apart from below.
struct World {
    explicit World(const Scene &scene)
        : body(make_bullet_body(scene, world.getWorldInfo())),
          force(static_cast<btScalar>(scene.springs.stiffness[0]), 0.0F) {
        solver.setDeformableSolver(&body_solver);
        world.setImplicit(false);
        world.setGravity({0.0F, 0.0F, 0.0F});
        world.addSoftBody(body.get());
        world.addForce(body.get(), &force);
    }
    ~World() {
        world.removeForce(body.get(), &force);
        world.removeSoftBody(body.get());
    }
    World(const World &) = delete;
    World &operator=(const World &) = delete;

    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btDeformableBodySolver body_solver;
    btDeformableMultiBodyConstraintSolver solver;
    btDeformableMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration, &body_solver};
    std::unique_ptr<btSoftBody> body;
    btDeformableMassSpringForce force;
};

Run make(const Scene &scene, double time_step) {
    auto world = std::make_shared<World>(with_mean_stiffness(scene));
    return {.step = [world, h = static_cast<btScalar>(time_step)] { world->world.stepSimulation(h, 0); },
            .positions = [world] { return positions(*world->body); }};
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
    return {.name = {},
            .summary =
                "Bullet's btDeformable springs, explicit, the whole step of its world; all of the mean stiffness",
            .source = "Coumans, Han and others, Bullet 3.24",
            .methods = {method}};
}

} // namespace livermark::benchmarks::peers
