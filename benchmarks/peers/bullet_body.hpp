#pragma once

#include <BulletSoftBody/btSoftBody.h>
#include <memory>
#include <vector>

#include "benchmarks/competitor.hpp"
#include "benchmarks/peers/bullet_scene.hpp"

/// Parts that both peers from Bullet share.
namespace livermark::benchmarks {

/// The springs of a scene as links at rest, then stretched. Bullet marks what is constrained by a mass of zero.
inline std::unique_ptr<btSoftBody> make_bullet_body(const Scene &scene, btSoftBodyWorldInfo &info) {
    info.m_gravity.setZero();
    info.air_density = 0.0F;
    std::vector<btVector3> rest;
    std::vector<btScalar> mass;
    for (std::size_t i = 0; i < scene.start.size(); ++i) {
        rest.push_back(to_bullet(scene.problem.body->mesh.points[i]));
        mass.push_back(scene.is_constrained[i] ? 0.0F : static_cast<btScalar>(scene.springs.node_mass[i]));
    }
    auto body = std::make_unique<btSoftBody>(&info, static_cast<int>(rest.size()), rest.data(), mass.data());
    for (const auto &[i, j] : scene.springs.edges)
        body->appendLink(i, j);
    // Done now: the first step would take the stretched lengths for those at rest.
    body->updateConstants();
    body->m_bUpdateRtCst = false;
    for (int i = 0; i < body->m_nodes.size(); ++i) {
        auto &node = body->m_nodes[i];
        node.m_x = node.m_q = to_bullet(scene.start[i]);
    }
    body->m_cfg.kDP = 0.0F;
    body->m_cfg.piterations = 1;
    body->m_cfg.collisions = 0;
    body->setActivationState(DISABLE_DEACTIVATION);
    return body;
}

inline std::vector<core::Vector3> positions(const btSoftBody &body) {
    std::vector<core::Vector3> positions;
    positions.reserve(body.m_nodes.size());
    for (int i = 0; i < body.m_nodes.size(); ++i)
        positions.push_back(from_bullet(body.m_nodes[i].m_x));
    return positions;
}

} // namespace livermark::benchmarks
