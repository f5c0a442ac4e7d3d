#pragma once

#include <LinearMath/btVector3.h>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::benchmarks {

inline btVector3 to_bullet(const core::Vector3 &x) {
    return {static_cast<btScalar>(x.x()), static_cast<btScalar>(x.y()), static_cast<btScalar>(x.z())};
}

inline core::Vector3 from_bullet(const btVector3 &x) {
    return {x.x(), x.y(), x.z()};
}

} // namespace livermark::benchmarks
