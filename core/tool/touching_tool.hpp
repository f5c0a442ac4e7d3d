#pragma once

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// A rigid ball that touches the surface and does not stick to it: contact without adhesion, with Coulomb friction.
struct TouchingTool {
    double radius = 0.0;             ///< [m], > 0
    Vector3 start = Vector3::Zero(); ///< its centre when it just touches the body at rest [m]
    Vector3 press = Vector3::Zero(); ///< by which the centre moves to the whole of the load, inwards [m]
    double friction = 0.0;           ///< coefficient, >= 0
};

} // namespace livermark::core
