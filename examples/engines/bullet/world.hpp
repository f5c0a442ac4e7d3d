// Bullet's world with one deformable body: its law, its solver, forces at nodes, and the rigid ball that presses it.
// All is in SI units, in single precision.
#pragma once

#include "examples/engines/bullet/files.hpp"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

inline btVector3 vector(const std::vector<double> &values, std::size_t i) {
    return {static_cast<btScalar>(values[3 * i]), static_cast<btScalar>(values[3 * i + 1]),
            static_cast<btScalar>(values[3 * i + 2])};
}

/// A quarter of each tetrahedron at each of its nodes.
inline std::vector<btScalar> node_masses(const Input &input) {
    std::vector<btScalar> mass(input.num_nodes(), 0.0F);
    for (std::size_t t = 0; t < input.tetrahedra.size(); t += 4) {
        const int *nodes = &input.tetrahedra[t];
        const btVector3 origin = vector(input.points, nodes[0]);
        const btScalar volume = (vector(input.points, nodes[1]) - origin)
                                    .cross(vector(input.points, nodes[2]) - origin)
                                    .dot(vector(input.points, nodes[3]) - origin) /
                                6.0F;
        for (int corner = 0; corner < 4; ++corner)
            mass[nodes[corner]] += static_cast<btScalar>(input.density[0]) * volume / 4.0F;
    }
    return mass;
}

/// Bullet's solver, whose numbers of iterations its programs can reach in no other way. Under a ball it takes out of
/// the residual what contact bears, again and again: Bullet does so once, and what rounding leaves makes steps of
/// conjugate gradients huge when little else is left.
class Solver : public btDeformableBodySolver {
  public:
    explicit Solver(const Settings &settings) {
        m_maxNewtonIterations = settings.newton;
        m_newtonTolerance = settings.newton > 1 ? 0.0F : m_newtonTolerance;
        m_cg.m_maxIterations = settings.iterations;
    }

    void solveDeformableConstraints(btScalar step) override {
        if (m_objective->m_projection.m_nodeRigidConstraints[0].size() == 0)
            return btDeformableBodySolver::solveDeformableConstraints(step);
        for (int newton = 0; newton < m_maxNewtonIterations; ++newton) {
            updateState();
            for (int i = 0; i < m_numNodes; ++i) {
                const btScalar inverse_mass = m_softBodies[0]->m_nodes[i].m_im;
                m_residual[i] = inverse_mass > 0.0F ? m_dv[i] * (-1.0F / inverse_mass) : btVector3(0, 0, 0);
                m_ddv[i].setZero();
            }
            m_objective->computeResidual(step, m_residual);
            for (int again = 0; again < 3; ++again)
                m_objective->project(m_residual);
            m_cg.solve(*m_objective, m_ddv, m_residual, false);
            updateDv();
        }
        updateVelocity();
    }

    /// Numbers of the nodes that the ball presses.
    std::vector<int> pressed() const {
        std::vector<int> nodes;
        const auto &contacts = m_objective->m_projection.m_nodeRigidConstraints[0];
        for (int k = 0; k < contacts.size(); ++k)
            if (contacts[k].m_binding)
                nodes.push_back(contacts[k].m_node->index);
        return nodes;
    }
};

/// Forces at nodes that do not depend on the displacement. Bullet has none such but gravity.
class DeadForces : public btDeformableLagrangianForce {
  public:
    explicit DeadForces(const std::vector<double> &forces) : forces_(forces) {}
    void addScaledForces(btScalar scale, TVStack &force) override {
        for (int i = 0; i < force.size(); ++i)
            force[i] += scale * factor * vector(forces_, i);
    }
    void addScaledExplicitForce(btScalar scale, TVStack &force) override { addScaledForces(scale, force); }
    void addScaledDampingForce(btScalar, TVStack &) override {}
    void addScaledElasticForceDifferential(btScalar, const TVStack &, TVStack &) override {}
    void addScaledDampingForceDifferential(btScalar, const TVStack &, TVStack &) override {}
    void buildDampingForceDifferentialDiagonal(btScalar, TVStack &) override {}
    btDeformableLagrangianForceType getForceType() override { return BT_MOUSE_PICKING_FORCE; } // any but gravity

    btScalar factor = 1.0F;

  private:
    const std::vector<double> &forces_;
};

/// The law with the Lame parameters of the material. Bullet's neo-Hookean energy has a logarithm that softens it: it
/// needs 4/3 mu and lambda + 5/6 mu (docs/studies/bullet.md).
inline std::unique_ptr<btDeformableLagrangianForce> make_law(const Input &input, const Settings &settings,
                                                             double mass_damping) {
    const double young = input.young_modulus[0], poisson = input.poisson_ratio[0];
    const double mu = young / (2.0 + 2.0 * poisson), lambda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
    if (settings.law == "neo_hookean")
        return std::make_unique<btDeformableNeoHookeanForce>(static_cast<btScalar>(4.0 / 3.0 * mu),
                                                             static_cast<btScalar>(lambda + 5.0 / 6.0 * mu),
                                                             static_cast<btScalar>(settings.stiffness_damping));
    return std::make_unique<btDeformableLinearElasticityForce>(static_cast<btScalar>(mu), static_cast<btScalar>(lambda),
                                                               static_cast<btScalar>(mass_damping),
                                                               static_cast<btScalar>(settings.stiffness_damping));
}

inline btVector3 vector(const std::array<double, 3> &values) {
    return {static_cast<btScalar>(values[0]), static_cast<btScalar>(values[1]), static_cast<btScalar>(values[2])};
}

/// A rigid ball that is set forward before each step, and touches nodes alone. A table of distances, with a mesh of
/// 1/24 of the radius, says how deep a node is in it.
class RigidBall {
  public:
    RigidBall(const Ball &ball, btDeformableMultiBodyDynamicsWorld &world, btSoftBody &body)
        : ball_(ball), world_(world), shape_(static_cast<btScalar>(ball.radius)), rigid_(0.0F, nullptr, &shape_) {
        body.m_cfg.collisions = btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN;
        body.m_cfg.kDF = 0.0F;
        body.getCollisionShape()->setMargin(0.0F);
        world.getWorldInfo().m_sparsesdf.setDefaultVoxelsz(static_cast<btScalar>(ball.radius / 24.0));
        world.getWorldInfo().m_sparsesdf.Reset();
        world.getSolverInfo().m_splitImpulse = 0;      // what it corrects beside velocities is undone by the next step
        world.getSolverInfo().m_deformable_erp = 0.2F; // of its depth a node comes out in a step
        rigid_.setFriction(0.0F);
        world.addRigidBody(&rigid_);
        press(0.0);
    }
    ~RigidBall() { world_.removeRigidBody(&rigid_); }
    RigidBall(const RigidBall &) = delete;
    RigidBall &operator=(const RigidBall &) = delete;

    /// Moves the ball to a part of its way.
    void press(double part) {
        const btTransform to(btQuaternion::getIdentity(),
                             vector(ball_.start) + static_cast<btScalar>(part) * vector(ball_.press));
        rigid_.setWorldTransform(to);
        rigid_.setInterpolationWorldTransform(to);
        world_.updateSingleAabb(&rigid_);
    }

    /// Puts pressed nodes that have come out of the ball just below its surface, and stops all that touch. Bullet finds
    /// no contact at the surface itself, and lets a node go that still moves outwards.
    void keep(const std::vector<int> &pressed, btSoftBody &body) {
        const auto depth = static_cast<btScalar>(1e-4 * ball_.radius);
        for (const int i : pressed) {
            auto &node = body.m_nodes[i];
            btVector3 normal;
            const btScalar distance = world_.getWorldInfo().m_sparsesdf.Evaluate(
                rigid_.getWorldTransform().invXform(node.m_x), &shape_, normal, 0.0F);
            if (distance > -depth)
                node.m_x -= (distance + depth) * normal;
        }
        for (int k = 0; k < body.m_nodeRigidContacts.size(); ++k) {
            auto &node = body.m_nodes[body.m_nodeRigidContacts[k].m_node->index];
            node.m_v = node.m_vn = btVector3(0, 0, 0);
        }
    }

  private:
    const Ball &ball_;
    btDeformableMultiBodyDynamicsWorld &world_;
    btSphereShape shape_;
    btRigidBody rigid_;
};

/// A world with the body, and with the ball that touches it. A tool of a scene has hold of its nodes, and touches none.
class World {
  public:
    World(const Input &input, const Settings &settings, double mass_damping)
        : mass(node_masses(input)), law(make_law(input, settings, mass_damping)), solver_(settings),
          damping_(settings.law == "neo_hookean" ? mass_damping : 0.0) {
        constraints_.setDeformableSolver(&solver_);
        world_.setGravity({0, 0, 0});
        world_.setImplicit(true);
        world_.setUseProjection(true); // without it implicit steps have no preconditioner to go on with
        for (int i = 0; i < input.num_nodes(); ++i)
            points.push_back(vector(input.points, i));
        body = std::make_unique<btSoftBody>(&world_.getWorldInfo(), input.num_nodes(), points.data(), mass.data());
        for (std::size_t t = 0; t < input.tetrahedra.size(); t += 4)
            body->appendTetra(input.tetrahedra[t], input.tetrahedra[t + 1], input.tetrahedra[t + 2],
                              input.tetrahedra[t + 3]);
        body->m_tetraScratches.resize(body->m_tetras.size());
        body->m_tetraScratchesTn.resize(body->m_tetras.size());
        body->initializeDmInverse();
        body->m_cfg.collisions = 0;
        body->setActivationState(DISABLE_DEACTIVATION);
        for (const auto *nodes : {&input.held, &input.tool})
            for (const int node : *nodes)
                body->setMass(node, 0.0F);
        world_.addSoftBody(body.get());
        world_.addForce(body.get(), law.get());
        if (input.touch) {
            add_links(input);
            ball.emplace(*input.touch, world_, *body);
        }
    }
    ~World() {
        ball.reset();
        world_.removeSoftBody(body.get());
    }
    World(const World &) = delete;
    World &operator=(const World &) = delete;

    void add(btDeformableLagrangianForce &force) { world_.addForce(body.get(), &force); }
    void step(double time_step) {
        const std::clock_t start = std::clock();
        world_.stepSimulation(static_cast<btScalar>(time_step), 0);
        for (int i = 0; damping_ > 0.0 && i < body->m_nodes.size(); ++i)
            body->m_nodes[i].m_v *= static_cast<btScalar>(std::exp(-damping_ * time_step));
        if (ball)
            ball->keep(solver_.pressed(), *body);
        ticks_ += std::clock() - start;
    }
    double seconds() const { return static_cast<double>(ticks_) / CLOCKS_PER_SEC; } ///< of all steps

    std::vector<btScalar> mass;
    std::vector<btVector3> points;
    std::unique_ptr<btSoftBody> body;
    std::unique_ptr<btDeformableLagrangianForce> law;
    std::optional<RigidBall> ball; ///< of a problem that has one

  private:
    /// Edges, by which Bullet builds its tree of nodes. No law pulls along them.
    void add_links(const Input &input) {
        std::set<std::pair<int, int>> edges;
        for (std::size_t t = 0; t < input.tetrahedra.size(); t += 4)
            for (int a = 0; a < 4; ++a)
                for (int b = 0; b < a; ++b)
                    edges.insert(std::minmax(input.tetrahedra[t + a], input.tetrahedra[t + b]));
        for (const auto &[a, b] : edges)
            body->appendLink(a, b);
    }

    btSoftBodyRigidBodyCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_{&configuration_};
    btDbvtBroadphase broadphase_;
    Solver solver_;
    btDeformableMultiBodyConstraintSolver constraints_;
    btDeformableMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &constraints_, &configuration_, &solver_};
    double damping_; // of the mass [1/s], which the neo-Hookean law does not have
    std::clock_t ticks_ = 0;
};
