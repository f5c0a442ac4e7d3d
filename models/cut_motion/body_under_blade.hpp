#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "models/tool_motion/moving_method.hpp"
#include "msm/nodal_conditions.hpp"

/// Methods that move a body under constant loads while it is cut.
namespace livermark::models {

/// A body under constant loads as methods with point masses see it.
struct ProblemOnNodes {
    std::shared_ptr<const core::Body> body;
    std::vector<double> node_mass; ///< (N) [kg]
    msm::NodalConditions conditions;
};

ProblemOnNodes on_nodes(const core::Problem &problem);

/// Frames of a motion, and its damping.
struct FramesUnderBlade {
    double interval = 1.0 / 60.0; ///< [s]
    double mass_damping = 7.0;    ///< alpha [1/s]: forces -alpha m v, as under the tools of load_cases/moving/
};

/// A body that begins at rest under constant loads. No tool has hold of it.
class BodyUnderBlade : public MovingBody {
  public:
    /// Goes on with what a cut along facets has left: each node is where it was, or where that was from which it was
    /// parted, and as fast. What the next frame needs is prepared.
    /// @param after               the same loads on the body that is left
    /// @param parent_tetrahedron  (M') the tetrahedron before that each is
    virtual void cut(const ProblemOnNodes &after, const std::vector<int> &parent_tetrahedron) = 0;

    void let_go() final {}
    core::Vector3 tool_force() const final { return core::Vector3::Zero(); }
};

struct MethodUnderBlade {
    std::string name;
    std::function<std::unique_ptr<BodyUnderBlade>(const ProblemOnNodes &problem, const FramesUnderBlade &frames)>
        prepare;
};

/// Springs, whose vector layout is changed around a cut alone, and interactive methods, which keep their orders.
/// Those with scaled masses are not among them.
std::vector<MethodUnderBlade> methods_under_blade();

} // namespace livermark::models
