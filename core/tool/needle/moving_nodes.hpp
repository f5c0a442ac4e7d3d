#pragma once

#include <functional>
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

/// Action on the nodes of a body after each explicit step: a needle, say.
/// @param nodes  as the step has left them; kicks end up in positions and velocities
/// @param part   of the way of a longer step that is behind, up to 1
/// @param h      length of the step [s]
using AfterStep = std::function<void(MovingNodes &nodes, double part, double h)>;

} // namespace livermark::core
