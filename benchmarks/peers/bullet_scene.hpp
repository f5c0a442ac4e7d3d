#pragma once

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized" // gcc 12 suspects a default argument in Bullet's headers
#endif

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <memory>
#include <span>
#include <vector>

#include "benchmarks/harness.hpp"
#include "interactive/scene.hpp"

/// Scenes of interactive methods in Bullet's worlds: the same nodes in the same order, the same masses and time steps,
/// and nobody looks for contact.
namespace livermark::benchmarks {

inline btVector3 to_bullet(const core::Vector3 &x) {
    return {static_cast<btScalar>(x.x()), static_cast<btScalar>(x.y()), static_cast<btScalar>(x.z())};
}

inline core::Vector3 from_bullet(const btVector3 &x) {
    return {x.x(), x.y(), x.z()};
}

/// Nodes at rest; Bullet marks those whose positions are set from outside by a mass of zero.
inline std::unique_ptr<btSoftBody> bullet_nodes(const interactive::Scene &scene, btSoftBodyWorldInfo &info) {
    info.m_gravity.setZero();
    info.air_density = 0.0F;
    std::vector<btVector3> points;
    std::vector<btScalar> mass(scene.node_mass.begin(), scene.node_mass.end());
    for (const auto &point : scene.body->mesh.points)
        points.push_back(to_bullet(point));
    for (const int node : scene.constrained_nodes)
        mass[node] = 0.0F;
    auto body = std::make_unique<btSoftBody>(&info, static_cast<int>(points.size()), points.data(), mass.data());
    body->m_cfg.collisions = 0;
    body->setActivationState(DISABLE_DEACTIVATION);
    return body;
}

/// The tetrahedra of the mesh.
inline void append_tetrahedra(btSoftBody &body, const core::TetraMesh &mesh) {
    for (const auto &[a, b, c, d] : mesh.tetrahedra)
        body.appendTetra(a, b, c, d);
    body.m_tetraScratches.resize(body.m_tetras.size());
    body.m_tetraScratchesTn.resize(body.m_tetras.size());
    body.initializeDmInverse();
}

/// Springs on the edges, each with a part of its fault that position-based passes take away.
/// @param stiffness  of Bullet's (0, 1], one for all or one for each edge
inline void append_links(btSoftBody &body, std::span<const std::array<int, 2>> edges,
                         const std::vector<double> &stiffness) {
    for (std::size_t s = 0; s < edges.size(); ++s) {
        auto *material = s == 0 ? body.m_materials[0] : stiffness.size() > 1 ? body.appendMaterial() : nullptr;
        if (material != nullptr)
            material->m_kLST = static_cast<btScalar>(stiffness[s]);
        body.appendLink(edges[s][0], edges[s][1], material);
    }
    body.updateConstants();
    body.m_bUpdateRtCst = false; // or the first step would take the stretched lengths for those at rest
}

/// Both shape (3, N).
inline void set_state(btSoftBody &body, const interactive::Field &positions, const interactive::Field &velocities) {
    for (int i = 0; i < body.m_nodes.size(); ++i) {
        auto &node = body.m_nodes[i];
        node.m_x = node.m_q = to_bullet(positions.col(i));
        node.m_v = node.m_vn = to_bullet(velocities.col(i));
    }
}

/// shape (3, N)
inline interactive::Field positions_of(const btSoftBody &body) {
    interactive::Field x(3, body.m_nodes.size());
    for (int i = 0; i < body.m_nodes.size(); ++i)
        x.col(i) = from_bullet(body.m_nodes[i].m_x);
    return x;
}

/// Bullet's iterations, with its own numbers as defaults.
struct BulletIterations {
    bool implicit = false;
    int newton = 1;
    int conjugate_gradients = 300;
    double tolerance = SIMD_EPSILON; ///< of the square of the residual of conjugate gradients
};

/// Bullet's solver, whose numbers of iterations its programs can reach in no other way.
class BulletSolver : public btDeformableBodySolver {
  public:
    explicit BulletSolver(const BulletIterations &iterations) {
        m_maxNewtonIterations = iterations.newton;
        m_newtonTolerance = iterations.newton > 1 ? 0.0F : m_newtonTolerance;
        m_cg.m_maxIterations = iterations.conjugate_gradients;
        m_cg.setTolerance(static_cast<btScalar>(iterations.tolerance));
    }
};

/// btDeformableMultiBodyDynamicsWorld with one body and one law. Explicit steps are those of symplectic Euler. An
/// implicit one is Newton's method on backward Euler from x + h v, by conjugate gradients without a preconditioner; it
/// needs setUseProjection(true), because the other way of constraints has no preconditioner for it.
struct BulletDeformable {
    BulletDeformable(const interactive::Scene &scene, std::unique_ptr<btDeformableLagrangianForce> law,
                     const BulletIterations &iterations)
        : solver(iterations), body(bullet_nodes(scene, world.getWorldInfo())), force(std::move(law)) {
        constraints.setDeformableSolver(&solver);
        world.setImplicit(iterations.implicit);
        world.setUseProjection(iterations.implicit);
        world.setGravity({0.0F, 0.0F, 0.0F});
        world.addSoftBody(body.get());
        world.addForce(body.get(), force.get());
    }
    ~BulletDeformable() { world.removeSoftBody(body.get()); }
    BulletDeformable(const BulletDeformable &) = delete;
    BulletDeformable &operator=(const BulletDeformable &) = delete;

    void step(double time_step) { world.stepSimulation(static_cast<btScalar>(time_step), 0); }

    /// Places of the constrained nodes at the end of the next step. shape (3, C) [m]
    void set_targets(const interactive::Scene &scene, const interactive::Field &targets, double time_step) {
        for (std::size_t c = 0; c < scene.constrained_nodes.size(); ++c) {
            auto &node = body->m_nodes[scene.constrained_nodes[c]];
            const auto target = to_bullet(targets.col(static_cast<Eigen::Index>(c)));
            node.m_v = node.m_vn = (target - node.m_x) / static_cast<btScalar>(time_step);
        }
    }

    /// Before forces are asked for without a step.
    void prepare_forces() {
        for (int i = 0; i < body->m_nodes.size(); ++i)
            body->m_nodes[i].index = i;
        forces.resize(body->m_nodes.size());
    }

    /// Forces of the law alone, where the body is.
    /// @param keeps_rotations  that somebody else has put there, like the deformation gradients
    void evaluate_forces(bool keeps_rotations = false) {
        if (!keeps_rotations)
            body->updateDeformation();
        for (int i = 0; i < forces.size(); ++i)
            forces[i].setZero();
        force->addScaledExplicitForce(1.0F, forces);
    }

    /// shape (3, N) [N]
    interactive::Field evaluated_forces() const {
        interactive::Field result(3, forces.size());
        for (int i = 0; i < forces.size(); ++i)
            result.col(i) = from_bullet(forces[i]);
        return result;
    }

    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    BulletSolver solver;
    btDeformableMultiBodyConstraintSolver constraints;
    btDeformableMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &constraints, &configuration, &solver};
    std::unique_ptr<btSoftBody> body;
    std::unique_ptr<btDeformableLagrangianForce> force;
    btDeformableLagrangianForce::TVStack forces;
};

/// btSoftRigidDynamicsWorld with one body of links, moved by passes over positions.
struct BulletPositionBased {
    BulletPositionBased(const interactive::Scene &scene, int iterations)
        : body(bullet_nodes(scene, world.getWorldInfo())) {
        body->m_cfg.piterations = iterations;
        world.setGravity({0.0F, 0.0F, 0.0F});
        world.addSoftBody(body.get());
    }
    ~BulletPositionBased() { world.removeSoftBody(body.get()); }
    BulletPositionBased(const BulletPositionBased &) = delete;
    BulletPositionBased &operator=(const BulletPositionBased &) = delete;

    void step(double time_step) { world.stepSimulation(static_cast<btScalar>(time_step), 0); }

    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    std::unique_ptr<btSoftBody> body;
};

/// The nodes of a scene of springs.
inline interactive::Scene nodes_of(const Scene &scene) {
    interactive::Scene nodes{.body = scene.problem.body, .node_mass = scene.springs.node_mass, .constrained_nodes = {}};
    for (std::size_t i = 0; i < scene.is_constrained.size(); ++i)
        if (scene.is_constrained[i])
            nodes.constrained_nodes.push_back(static_cast<int>(i));
    return nodes;
}

/// Moves the springs of a scene in a world with its nodes, as links at rest that are then stretched.
/// @param link_stiffness  see append_links()
template <class World>
Run run_springs(const std::shared_ptr<World> &world, const Scene &scene, double link_stiffness, double time_step) {
    append_links(*world->body, scene.springs.edges, {link_stiffness});
    interactive::Field start(3, static_cast<Eigen::Index>(scene.start.size()));
    for (Eigen::Index i = 0; i < start.cols(); ++i)
        start.col(i) = scene.start[static_cast<std::size_t>(i)];
    set_state(*world->body, start, interactive::Field::Zero(3, start.cols()));
    return {.step = [world, time_step] { world->step(time_step); },
            .positions =
                [world] {
                    const auto x = positions_of(*world->body);
                    return std::vector<core::Vector3>(x.colwise().begin(), x.colwise().end());
                }};
}

} // namespace livermark::benchmarks
