#pragma once

#include <vector>

#include "core/tool/tool_motion.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::models {

/// The place of a moving tool as a model with point masses sees it: T nodes, and what is held beside them.
struct ToolPlace {
    std::vector<int> nodes;                   ///< (T)
    std::vector<core::Vector3> pressed, slid; ///< (T) displacement at the whole depth, and of the whole slide [m]
    std::vector<int> held;                    ///< nodes that never move
    msm::NodalConditions while_held, let_go;  ///< of all nodes, with and without the tool
    core::ToolMotion motion;

    core::Vector3 displacement(std::size_t i, const core::ToolPosition &position) const {
        return position.pressed * pressed[i] + position.slid * slid[i];
    }
};

/// @param problem    of a load case with a tool
/// @param node_mass  shape (N) [kg]
ToolPlace tool_place(const core::Problem &problem, const std::vector<double> &node_mass);

} // namespace livermark::models
