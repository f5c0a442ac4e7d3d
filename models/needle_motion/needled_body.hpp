#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "core/tool/needle/needle.hpp"
#include "models/tool_motion/moving_method.hpp"

/// Methods that move a body in real time, with a needle in it.
namespace livermark::models {

/// How a hand leads a needle: from the entry to the target at one speed, a rest, and out at the same speed, frame by
/// frame.
struct NeedlePlan {
    double speed = 0.02;                ///< of the hand [m/s], > 0
    double rest = 0.5;                  ///< at the target [s], >= 0
    double frame_interval = 1.0 / 60.0; ///< [s]
    double mass_damping = 10.0;         ///< alpha of the body [1/s]

    /// The frame at whose end the tip is to be at the target: it is the record at_plan.
    int at_plan(const core::Needle &needle) const;
    /// Until the needle is drawn out again.
    int num_frames(const core::Needle &needle) const;
    /// Of the tip below the entry at rest, as the hand leads it, at the end of a frame; 0 at record 0 [m].
    double depth_after(const core::Needle &needle, int frame) const;
};

/// What a needle meets in a frame.
struct NeedleReading {
    double force = 0.0;                  ///< of the hand, inwards [N]: in explicit steps the mean over the frame
    double tip = 0.0;                    ///< how much of the tissue's path is behind the tip, at rest [m]
    std::vector<core::Vector3> places{}; ///< (K) displacement of the places of core::needle_line() [m]
};

/// A body with a needle, from rest. For one thread; the same calls give the same bits.
class NeedledBody {
  public:
    NeedledBody() = default;
    virtual ~NeedledBody() = default;
    NeedledBody(const NeedledBody &) = delete;
    NeedledBody &operator=(const NeedledBody &) = delete;

    /// Prepares what the next frames need, so that these do not take time for it.
    virtual void prepare_for(const Effort & /*effort*/) {}

    /// Moves on by a frame, at the end of which the hand has led the needle to a depth.
    /// @param depth  of the tip below the entry at rest [m]
    virtual void advance(double depth, const Effort &effort) = 0;

    /// The same without the needle, which is left where it is: what a frame costs without it.
    virtual void advance_alone(const Effort &effort) = 0;

    /// Goes on from where another body is.
    /// @param other  of the same method and problem
    virtual void take_motion_of(const NeedledBody &other) = 0;

    /// (N) of all nodes [m]
    virtual std::vector<core::Vector3> displacement() const = 0;
    virtual NeedleReading reading() const = 0;
    virtual FrameCost cost(const Effort &effort) const = 0;

    /// What a frame takes at least, because longer steps are unstable; nothing if every step is stable.
    virtual std::optional<Effort> least_effort() const { return std::nullopt; }
};

/// Makes one.
/// @param problem  that constrains whole nodes where they are, and nothing else
using PrepareNeedled = std::function<std::unique_ptr<NeedledBody>(const core::Problem &problem,
                                                                  const core::Needle &needle, const NeedlePlan &plan)>;

/// A method of the arena, with a needle.
struct NeedledMethod {
    MovingMethod texts;     ///< whose body knows no needle
    PrepareNeedled prepare; ///< empty where the method holds none
    std::string obstacle{}; ///< why it does not, a clause; empty where it does
};

/// One for each of all_moving_methods(), in that order.
std::vector<NeedledMethod> all_needled_methods();

} // namespace livermark::models
