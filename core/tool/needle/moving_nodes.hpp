#pragma once

#include <span>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// Nodes of a body that moves in steps, as a needle in it sees them: one of each method of steps.
class MovingNodes {
  public:
    MovingNodes() = default;
    virtual ~MovingNodes() = default;
    MovingNodes(const MovingNodes &) = delete;
    MovingNodes &operator=(const MovingNodes &) = delete;

    /// Displacements of some nodes, as they are now [m].
    virtual void displacements(std::span<const int> nodes, std::span<Vector3> found) const = 0;

    /// Gives some nodes more velocity [m/s], and moves them on by as much in a step, as if a force had acted in the
    /// last one. Constrained nodes are given none.
    /// @param time_step  h of the last step [s]
    virtual void kick(std::span<const int> nodes, std::span<const Vector3> velocity, double time_step) = 0;
};

} // namespace livermark::core
