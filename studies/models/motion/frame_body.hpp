#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/problem.hpp"
#include "core/tool/needle/moving_needle.hpp"
#include "core/tool/stepper.hpp"
#include "core/tool/tool_motion.hpp"

/// Bodies that move frame by frame under a tool, a needle or a blade.
namespace livermark::models {

using core::Effort;
using core::FrameCost;
using core::NodalProblem;
using core::Stepper;

NodalProblem on_nodes(const core::Problem &problem);

/// Least work in a frame of this length [s]; nothing where every step is stable.
std::optional<Effort> least_effort(const Stepper &stepper, double frame);

/// The place of a moving tool as a model with point masses sees it: T nodes, and what is held beside them.
struct ToolPlace {
    std::vector<int> nodes;                   ///< (T)
    std::vector<core::Vector3> pressed, slid; ///< (T) displacement at the whole depth, and of the whole slide [m]
    std::vector<int> held;                    ///< nodes that never move
    core::NodalConditions while_held, let_go; ///< of all nodes at rest, with and without the tool
    core::ToolMotion motion;

    core::Vector3 displacement(std::size_t i, const core::ToolPosition &position) const {
        return position.pressed * pressed[i] + position.slid * slid[i];
    }
};

/// @param problem    of a load case with a tool
/// @param node_mass  shape (N) [kg]
ToolPlace tool_place(const core::Problem &problem, const std::vector<double> &node_mass);

/// The way of a hand that leads a needle: from the entry to the target at one speed, a rest, and out at the same speed,
/// frame by frame.
struct NeedlePlan {
    double speed = 0.02;                ///< of the hand [m/s], > 0
    double rest = 0.5;                  ///< at the target [s], >= 0
    double frame_interval = 1.0 / 60.0; ///< [s]
    double mass_damping = 10.0;         ///< alpha of the body [1/s]

    /// The frame at whose end the tip is to be at the target: it is the record at_plan.
    int at_plan(const core::Needle &needle) const;
    /// Number of frames until the needle is drawn out again.
    int num_frames(const core::Needle &needle) const;
    /// Depth of the tip below the entry at rest, as the hand leads it, at the end of a frame; 0 at record 0 [m].
    double depth_after(const core::Needle &needle, int frame) const;
};

/// Measurement of a needle in a frame.
struct NeedleReading {
    double force = 0.0;                  ///< of the hand, inwards [N]: in explicit steps the mean over the frame
    double tip = 0.0;                    ///< how much of the tissue's path is behind the tip, at rest [m]
    std::vector<core::Vector3> places{}; ///< (K) displacement of the places of core::needle_line() [m]
};

/// Frames of a motion under a blade, and its damping.
struct FramesUnderBlade {
    double interval = 1.0 / 60.0; ///< [s]
    double mass_damping = 7.0;    ///< alpha [1/s]: forces -alpha m v, as under the tools of load_cases/moving/
};

/// A hand in a frame: where it leads the tool or the needle.
struct Lead {
    double start = 0.0; ///< of the frame, since the motion of the tool began [s]
    double depth = 0.0; ///< of the needle's tip below the entry at rest, at the end of the frame [m]
};

/// A body that moves frame by frame, from rest, and what acts on it: at most one tool, and a needle. Cuts are the
/// stepper's. For one thread; the same calls give the same bits.
class FrameBody {
  public:
    /// @param frame_interval  [s]
    FrameBody(std::unique_ptr<Stepper> stepper, double frame_interval);

    /// A tool takes hold of its place, or is a ball that may touch (LoadCase::touching).
    void take_tool(ToolPlace place, const core::Problem &problem);

    /// A needle is at its entry.
    void take_needle(const core::Needle &needle, const core::TetraMesh &mesh);

    /// Prepares the next frames, so that these do not take time for it.
    void prepare_for(const Effort &effort);

    /// Moves on by a frame, with the tool on its way and the needle led to its depth. In explicit steps the needle acts
    /// after each of them. Otherwise it acts once in a frame: its forces last over the next one, and what a frame does
    /// with a force is observed at rest, since iterations that have not converged give way several times as far as
    /// backward Euler.
    /// @param effort  that the body was prepared for last, if it ever was
    void advance(const Lead &lead, const Effort &effort);

    /// The same without tool and needle, which are left where they are: the cost of a frame without them.
    void advance_alone(const Effort &effort);

    /// The tool lets go. What has to be prepared for that is prepared here.
    void let_go();

    /// Stepper::cut().
    void cut(const NodalProblem &after, const std::vector<int> &parent_tetrahedron) {
        stepper_->cut(after, parent_tetrahedron);
    }

    /// Stepper::take_motion_of().
    void take_motion_of(const FrameBody &other) { stepper_->take_motion_of(*other.stepper_); }

    /// Displacements of all nodes, shape (N) [m].
    std::vector<core::Vector3> displacement() const { return stepper_->displacement(); }

    /// Force of the body on the tool [N]; zero once it has let go. Where the tool has hold of a place, elastic; where
    /// it touches, the mean over the last frame: minus what momentum it gave the body over the length of the frame.
    core::Vector3 tool_force() const;

    NeedleReading reading() const;
    FrameCost cost(const Effort &effort) const { return stepper_->cost(effort); }

    /// Least work in a frame, because longer steps are unstable; nothing if every step is stable.
    std::optional<Effort> least_effort() const { return models::least_effort(*stepper_, frame_); }

  private:
    bool has_explicit_steps() const { return least_effort().has_value(); }
    void lead_tool(double time);

    std::unique_ptr<Stepper> stepper_;
    double frame_; ///< [s]
    std::optional<ToolPlace> place_;
    core::TouchingTool ball_shape_;
    std::shared_ptr<core::BallContact> ball_; ///< null where the tool has hold of its place, or none is there
    core::Vector3 ball_force_ = core::Vector3::Zero();
    bool has_let_go_ = false;
    std::optional<core::MovingNeedle> needle_;
    double needle_force_ = 0.0; ///< [N]

    // Of implicit methods with a needle.
    core::PlaceWeights weights_;
    double force_of_observation_ = 0.0; ///< [N]
};

} // namespace livermark::models
