#pragma once

#include <memory>
#include <vector>

#include "interactive/method.hpp"

namespace livermark::interactive {

/// What a cut along facets leaves of the body of a scene: tetrahedra are gone, or have nodes of their own where they
/// had them with others. Corners keep their order.
struct SceneCut {
    std::shared_ptr<const core::Body> body;
    std::vector<double> node_mass;       ///< (N') [kg]
    std::vector<int> parent_tetrahedron; ///< (M') that each tetrahedron was before, no two the same
};

/// A method goes on with what a cut leaves of a moving body. Nodes have the positions and velocities that they had, or
/// that those had from which they were parted; copies of a constrained node are constrained, with its target; external
/// forces on a node are shared among its copies by their masses. So a cut that parts keeps the momentum, and one that
/// takes tetrahedra away that of what is left. The motion is that of a set-up of the cut body with this state; the
/// orders of the layout are those before the cut, as_cut(). A ball and a correction of steps have to be given again,
/// and steps prepared: prepare().
/// @param method  that of the simulation
/// @param before  a simulation of the body before; it can go on as well
/// @throws std::invalid_argument if a parent is none of the tetrahedra before, or there twice
std::unique_ptr<Simulation> continue_after_cut(const Method &method, const Simulation &before, const SceneCut &cut);

} // namespace livermark::interactive
