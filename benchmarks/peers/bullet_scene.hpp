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
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "benchmarks/harness.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/elements/implicit_elements.hpp"
#include "interactive/kernels/orders.hpp"
#include "interactive/method.hpp"
#include "tests/oracles/explicit_steps.hpp"
#include "tests/oracles/implicit_steps.hpp"

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

    /// Prepares forces that are asked for without a step.
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

/// The laws of Bullet's tetrahedra, as its headers have them, in double precision: energies per volume as those of
/// interactive/elements/energies.hpp. Its third law, btDeformableLinearElasticityForce, is
/// interactive::densities::Corotational but for the rotation that it takes.
namespace livermark::benchmarks::bullet_laws {

using interactive::Matrix3;
using interactive::densities::Tangent;

/// btDeformableNeoHookeanForce: W = mu / 2 (I1 - 3 - ln(I1 + 1)) + lambda / 2 (J - 1 - 3 mu / (4 lambda))^2.
/// (Smith, De Goes, Kim 2018, Stable neo-Hookean flesh simulation, ACM TOG 37(2), eq. 14)
struct NeoHookean {
    double mu, lambda;

    /// Parameters that give small strains the Lame parameters of a material: 4/3 mu and lambda + 5/6 mu.
    /// (the same, eq. 16)
    static NeoHookean for_small_strains(double mu, double lambda) {
        return {.mu = 4.0 / 3.0 * mu, .lambda = lambda + 5.0 / 6.0 * mu};
    }

    double value(const Matrix3 &f) const {
        const double square = f.squaredNorm(), growth = f.determinant() - 1.0 - 0.75 * mu / lambda;
        return 0.5 * mu * (square - 3.0 - std::log(square + 1.0)) + 0.5 * lambda * growth * growth;
    }
    Matrix3 stress(const Matrix3 &f) const { return shear(f) * f + pressure(f) * interactive::cofactors(f); }
    Tangent tangent(const Matrix3 &f) const {
        const Eigen::Matrix<double, 9, 1> c = interactive::densities::by_columns(interactive::cofactors(f)),
                                          a = interactive::densities::by_columns(f);
        const double base = f.squaredNorm() + 1.0;
        return shear(f) * Tangent::Identity() + 2.0 * mu / (base * base) * a * a.transpose() +
               lambda * c * c.transpose() + pressure(f) * interactive::densities::determinant_tangent(f);
    }

  private:
    double shear(const Matrix3 &f) const { return mu * (1.0 - 1.0 / (f.squaredNorm() + 1.0)); }
    double pressure(const Matrix3 &f) const { return lambda * (f.determinant() - 1.0) - 0.75 * mu; }
};

/// btDeformableCorotatedForce: W = mu |F - R|^2 + lambda / 2 (J - 1)^2. Only its stress: Bullet has no more of it
/// either.
struct Corotated {
    double mu, lambda;

    Matrix3 stress(const Matrix3 &f) const {
        return 2.0 * mu * (f - interactive::densities::rotation(f)) +
               lambda * (f.determinant() - 1.0) * interactive::cofactors(f);
    }
};

} // namespace livermark::benchmarks::bullet_laws

/// Methods of ours with the materials that Bullet has.
namespace livermark::benchmarks {

/// Tetrahedra with the parameters that Bullet's neo-Hookean law needs for the material.
inline std::vector<interactive::Tetrahedron> tetrahedra_for_bullet(const core::Body &body) {
    auto tetrahedra = interactive::tetrahedra_at_rest(body);
    for (auto &t : tetrahedra) {
        const auto law = bullet_laws::NeoHookean::for_small_strains(t.mu, t.lambda);
        t.mu = law.mu;
        t.lambda = law.lambda;
    }
    return tetrahedra;
}

/// The steps of `tled` with Bullet's neo-Hookean law.
class BulletLawExplicit : public tests::CentralDifferences {
  public:
    explicit BulletLawExplicit(interactive::Scene given)
        : CentralDifferences(std::move(given)), energy_(tetrahedra_for_bullet(*scene().body)) {}

    const interactive::Energy &energy() const override { return energy_; }
    interactive::Cost cost(int iterations) const override {
        return {.element_passes = static_cast<double>(iterations),
                .bytes_per_element = sizeof(interactive::Tetrahedron)};
    }

  private:
    interactive::ElementEnergy<bullet_laws::NeoHookean> energy_;
};

/// Springs of `fast_mass_spring`, all with the mean stiffness: Bullet has one for all.
inline interactive::Springs springs_of_mean_stiffness(const core::Body &body) {
    auto springs = interactive::springs_with_shear_modulus(body);
    auto &k = springs.stiffness;
    k.assign(k.size(), std::accumulate(k.begin(), k.end(), 0.0) / static_cast<double>(k.size()));
    return springs;
}

/// The steps of `fast_mass_spring` with these.
class UniformMassSpring : public tests::Prefactored {
  public:
    explicit UniformMassSpring(const interactive::Scene &given)
        : Prefactored(given, interactive::laplacian(springs_of_mean_stiffness(*given.body))),
          energy_(springs_of_mean_stiffness(*given.body)) {}

    const interactive::SpringEnergy &energy() const override { return energy_; }
    interactive::Cost cost(int iterations) const override {
        return {.element_passes = static_cast<double>(iterations)};
    }

  private:
    interactive::SpringEnergy energy_;
};

/// Links in the order in which xpbd_springs visits its springs. Bullet has no compliance: in its first pass, each of
/// these takes away the part of its fault that the spring does with its own, w / (w + 1 / (k h^2)) with w the sum of
/// inverse masses.
struct CompliantLinks {
    std::vector<std::array<int, 2>> edges;
    std::vector<double> parts; ///< of (0, 1]
};

inline CompliantLinks links_as_compliant(const interactive::Scene &scene, double time_step) {
    const auto springs = interactive::springs_with_shear_modulus(*scene.body);
    const auto is_free = interactive::free_nodes(scene);
    const auto inverse_mass = [&](int i) { return is_free[i] ? 1.0 / scene.node_mass[i] : 0.0; };
    std::vector<std::vector<int>> sets;
    for (const auto &edge : springs.edges)
        sets.emplace_back(edge.begin(), edge.end());
    CompliantLinks links;
    for (const int s : interactive::colour_sets(sets, scene.body->mesh.num_nodes()).order) {
        const auto &[a, b] = springs.edges[s];
        const double weight = inverse_mass(a) + inverse_mass(b);
        links.edges.push_back(springs.edges[s]);
        links.parts.push_back(weight == 0.0 ? 1.0
                                            : weight / (weight + 1.0 / (springs.stiffness[s] * time_step * time_step)));
    }
    return links;
}

} // namespace livermark::benchmarks
