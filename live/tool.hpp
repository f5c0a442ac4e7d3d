#pragma once

#include "core/mesh/tetra_mesh.hpp"
#include "core/tool/needle/needle.hpp"

namespace livermark::live {

/// What the tool does. The numbers are those of the messages.
enum class ToolKind {
    none = 0,
    probe = 1, ///< a sphere that follows the target and is stopped by the surface, on which it presses as a round tool
    pull = 2,  ///< takes hold of the surface around a node and draws it to the target, with the same weights
    needle = 3 ///< goes from an entry towards a target inside, see msm/needle/moving_needle.hpp
};

struct Tool {
    ToolKind kind = ToolKind::none;
    core::Vector3 target = core::Vector3::Zero(); ///< of the centre of the sphere, or of the node [m]
    double radius = 0.012;                        ///< of the sphere, and of the disc that it presses or holds [m], > 0
    int node = 0;                                 ///< of the surface; looked at by a pull alone
    core::Needle needle{};                        ///< looked at by a needle alone, of which only `depth` changes
    double depth = 0.0;                           ///< of its tip below the entry at rest, as the hand leads it [m]
};

} // namespace livermark::live
