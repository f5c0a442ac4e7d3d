#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "msm/cutting/cut_parts.hpp"
#include "msm/elastic_body.hpp"
#include "studies/models/motion/frame_body.hpp"

namespace livermark::interactive {
struct Method;
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

} // namespace livermark::models
