#pragma once

#include <vector>

#include "core/tool/needle/moving_needle.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::msm {

/// A needle in explicit steps of springs.
class MovingNeedle : public core::MovingNeedle {
  public:
    /// @param mesh        at rest, where the springs are prepared
    /// @param node_mass   shape (N) [kg], those of the steps, not scaled ones
    /// @param conditions  of the steps; nodes that are constrained in all components take forces and do not move
    /// @throws std::invalid_argument if no point of the body is near a place
    MovingNeedle(const core::Needle &needle, const core::TetraMesh &mesh, const std::vector<double> &node_mass,
                 const NodalConditions &conditions);

    /// As of core::MovingNeedle.
    void begin(const FastSteps &steps);
    void act(FastSteps &steps, double depth, double time_step);
    core::Vector3 target_displacement(const FastSteps &steps) const;
    std::vector<core::Vector3> place_displacements(const FastSteps &steps) const;
};

} // namespace livermark::msm
