#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/problem.hpp"

/// Methods that move a body in real time, under a tool that moves.
namespace livermark::models {

/// What a method does in a frame: steps of equal length, and iterations in each.
struct Effort {
    int steps = 1;
    int iterations = 1;
};

/// What a frame costs, independent of the machine.
struct FrameCost {
    double element_passes = 0.0;    ///< how often all elements are visited for forces, or what takes their place
    double bytes_per_element = 0.0; ///< that are stored of the body, over the number of tetrahedra
};

/// A body that a tool moves, from rest. For one thread; the same calls give the same bits.
class MovingBody {
  public:
    MovingBody() = default;
    virtual ~MovingBody() = default;
    MovingBody(const MovingBody &) = delete;
    MovingBody &operator=(const MovingBody &) = delete;

    /// Prepares what the next frames need, so that these do not take time for it.
    virtual void prepare_for(const Effort & /*effort*/) {}

    /// Moves on by a frame, with the tool on its way.
    /// @param start   [s] since the motion began
    /// @param effort  that the body was prepared for last, if it ever was
    virtual void advance(double start, const Effort &effort) = 0;

    /// The tool lets go. What has to be prepared for that is prepared here.
    virtual void let_go() = 0;

    /// (N) of all nodes [m]
    virtual std::vector<core::Vector3> displacement() const = 0;

    /// Of the body on the tool [N]; zero once it has let go. Where the tool has hold of a place, elastic; where it
    /// touches, the mean over the last frame: minus what momentum it gave the body over the length of the frame.
    virtual core::Vector3 tool_force() const = 0;

    virtual FrameCost cost(const Effort &effort) const = 0;

    /// What a frame takes at least, because longer steps are unstable; nothing if every step is stable.
    virtual std::optional<Effort> least_effort() const { return std::nullopt; }
};

/// How a method uses the time that it has.
enum class Setting {
    one_step,       ///< a step in a frame, and as many iterations as fit
    ten_iterations, ///< as many steps as fit, with ten iterations each: what programs for games and robots do
    one_iteration   ///< as many steps as fit, with one iteration each: small steps
};
inline constexpr Setting all_settings[] = {Setting::one_step, Setting::ten_iterations, Setting::one_iteration};

/// The word for a setting in tables and files. Methods with a least_effort() have no choice.
const char *to_string(Setting setting);

/// A method in the arena.
struct MovingMethod {
    std::string name;
    std::string source;         ///< literature reference
    std::string implementation; ///< one line: how good it is, and its number format
    std::string converges_to;   ///< one line: what its steps come to
    std::string objection;      ///< what its users or authors object to, each with a source; how to see it here
    /// @param problem  of a load case with a tool
    std::function<std::unique_ptr<MovingBody>(const core::Problem &problem)> prepare;
    bool only_when_named = false;
    bool knows_contact = false; ///< whether it moves under a tool that touches (LoadCase::touching)
};

/// All that there are: springs on the fastest kernels, then interactive methods.
std::vector<MovingMethod> all_moving_methods();

} // namespace livermark::models
