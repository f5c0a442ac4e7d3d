#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "core/tool/tool_motion.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/elastic_body.hpp"
#include "studies/models/motion/frame_body.hpp"

namespace livermark::interactive {
struct Method;
struct Scene;
class Simulation;
class StepCorrection;
} // namespace livermark::interactive
namespace livermark::msm {
struct MassScaling;
}

/// Methods that move a body in real time: springs on the fastest kernels, and interactive methods.
namespace livermark::models {

/// Use that a method makes of its time.
enum class Setting {
    one_step,       ///< a step in a frame, and as many iterations as fit
    ten_iterations, ///< as many steps as fit, with ten iterations each: what programs for games and robots do
    one_iteration   ///< as many steps as fit, with one iteration each: small steps
};
inline constexpr Setting all_settings[] = {Setting::one_step, Setting::ten_iterations, Setting::one_iteration};

/// The word for a setting in tables and files. Methods with a least effort have no choice.
const char *to_string(Setting setting);

/// Settings of a stepper that do not change while it moves.
struct StepperOptions {
    double mass_damping = 0.0;  ///< alpha [1/s]: forces -alpha m v
    bool scales_masses = false; ///< those of stiff parts, of explicit methods
    bool may_be_cut = false;
};

/// A method of the arena, with a tool, a needle or a blade.
struct MovingMethod {
    std::string name;
    std::string source;         ///< literature reference
    std::string implementation; ///< one line: how good it is, and its number format
    std::string converges_to;   ///< one line: what its steps come to
    std::string objection;      ///< what its users or authors object to, each with a source; how to see it here
    /// Puts the method on a body at rest.
    /// @param problem        with displacements of zero where it is held
    /// @param once_released  the same with what is held once a tool has let go: steps are stable for both
    std::function<std::unique_ptr<Stepper>(const NodalProblem &problem, const core::NodalConditions &once_released,
                                           const StepperOptions &options)>
        prepare;
    bool only_when_named = false;
    bool knows_contact = false; ///< whether it moves under a tool that touches (LoadCase::touching)
    /// Whether masses of stiff parts are scaled. Then it holds no needle, whose impulses are those of true masses, and
    /// cannot be cut.
    bool is_scaled = false;

    /// @param problem  of a load case with a tool
    std::unique_ptr<FrameBody> under_tool(const core::Problem &problem) const;

    /// @param problem  that constrains whole nodes where they are, and nothing else
    std::unique_ptr<FrameBody> with_needle(const core::Problem &problem, const core::Needle &needle,
                                           const NeedlePlan &plan) const;

    /// @param problem  with displacements of zero where it is held
    std::unique_ptr<FrameBody> under_blade(const NodalProblem &problem, const FramesUnderBlade &frames) const;
};

/// All that there are: springs, then interactive methods.
std::vector<MovingMethod> all_moving_methods();

/// Springs that take explicit steps.
struct MovingSpringModel {
    std::string name;
    std::string source;    ///< literature reference
    std::string objection; ///< as of MovingMethod
    msm::ElasticBody (*make)(const core::Body &body);
    /// Origin of their stiffness; nothing of coupled springs
    std::optional<msm::SpringSource> (*spring_source)(const core::Body &body);
    bool is_scaled = false; ///< there is a method with masses scaled in stiff parts as well
    bool only_when_named = false;
};

std::span<const MovingSpringModel> moving_spring_models();

/// Steps of an interactive method; parameters as of MovingMethod::prepare.
std::unique_ptr<Stepper> method_stepper(const interactive::Method &method, const NodalProblem &problem,
                                        const core::NodalConditions &once_released, const StepperOptions &options);

/// Scales the stiff parts of a body so that they bear the steps of the rest: selective mass scaling of explicit
/// methods, by the same rules as of springs (msm/dynamics/time_step.hpp).
/// @param at_rest  whose constrained nodes belong to no part; nodes of the method's own belong to a part where the
///   edges are that they are on
msm::MassScaling scale_masses(const interactive::Simulation &at_rest);

/// The same where more nodes are constrained: those of a scene.
msm::MassScaling constrained(const msm::MassScaling &scaling, const interactive::Scene &scene);

/// The longest stable step with these masses.
/// @param scaling  with no part that has a constrained node
/// @return [s]; infinity if nothing can move
double critical_time_step(const interactive::Simulation &at_rest, const msm::MassScaling &scaling);

/// Correction that makes explicit steps those of the scaled masses. Damping by mass is in proportion to these.
/// @return null where no part is scaled
std::shared_ptr<interactive::StepCorrection> correction_of(msm::MassScaling scaling);

/// Whether a name is that of an interactive method that free_motion() takes: one without nodes of its own.
bool has_free_motion(std::string_view name);

/// The motion of an interactive method after all tractions of a load case are let go at t = 0: in steps of an output
/// interval with as many iterations as its users usually take, or, of a method with a longest stable step, as many as
/// that asks for.
/// @param name          has_free_motion()
/// @param problem       with a release, of which methods know the damping of the mass alone; whole nodes are
///                      constrained
/// @param displacement  where it starts, at rest; shape (N) [m]
/// @return without frames and energies; if the motion leaves all bounds, diverged_at says when, and the records from
///   then on are NaN
core::History free_motion(std::string_view name, const core::Problem &problem,
                          const std::vector<core::Vector3> &displacement);

/// The motion that those of methods are compared with: neo-Hookean quadratic tetrahedra on the mesh refined at the rims
/// of places, by the energy-momentum method. Records of the nodes of the mesh.
/// @param problem          of a load case with a tool
/// @param level            how often the mesh is refined
/// @param steps_per_frame  >= 1
/// @return fewer records than all where it finds no next step
core::ToolHistory reference_motion(const core::Problem &problem, int level, int steps_per_frame);

} // namespace livermark::models
