#pragma once

#include "core/mesh/tetra_mesh.hpp"
#include "core/tool/needle/needle.hpp"
#include "core/tool/stepper.hpp"

namespace livermark::live {

/// Kinds of tools. The numbers are those of the messages.
enum class ToolKind {
    none = 0,
    probe = 1, ///< a rigid ball that follows the target and touches the surface with friction
    pull = 2,  ///< takes hold of the surface around a node, as a round tool does, and draws it to the target
    needle = 3 ///< goes from an entry towards a target inside, see core/tool/needle/moving_needle.hpp
};

struct Tool {
    ToolKind kind = ToolKind::none;
    core::Vector3 target = core::Vector3::Zero(); ///< of the centre of the ball, or of the node [m]
    double radius = 0.012;                        ///< of the ball, or of the disc that is held [m], > 0
    int node = 0;                                 ///< of the surface; looked at by a pull alone
    /// Coulomb's coefficient of a probe, >= 0: that of load_cases/touching/large_touch.toml, so that a load case says
    /// the same.
    double friction = 0.3;
    core::Needle needle{}; ///< looked at by a needle alone, of which only `depth` changes
    double depth = 0.0;    ///< of its tip below the entry at rest, as the hand leads it [m]
};

/// The needle of the live page.

/// Reading of a needle, in the mean over the steps of a frame.
struct NeedleReading {
    double depth = 0.0;     ///< of the tip below the entry at rest, as the hand leads it now [m]
    double tip = 0.0;       ///< how much of the tissue's path is behind the tip, at rest [m]
    double force = 0.0;     ///< of the hand, inwards [N]
    double tip_force = 0.0; ///< [N]
    bool is_punctured = false;
    core::Vector3 target = core::Vector3::Zero(); ///< displacement of the target [m]
    core::NeedleWork work;                        ///< since the needle was taken
    std::vector<core::Vector3> forces{};          ///< (K) on the tissue at the places of core::needle_line() [N]
};

/// Speed at which the hand leads a needle at most [m/s].
inline constexpr double fastest_needle = 0.1;

/// A needle that somebody leads.
class HeldNeedle {
  public:
    HeldNeedle(const core::Needle &needle, const core::TetraMesh &mesh, const core::Stepper &steps);

    /// After a step that others have taken.
    /// @param depth  that the tool asks for [m]
    void act(core::Stepper &steps, double depth, double time_step);

    /// Over the steps since the last reading.
    NeedleReading reading(const core::Stepper &steps);

    double depth() const { return moving_.depth(); } ///< [m]
    /// Force on the tissue in the last step [N].
    core::Vector3 force() const { return moving_.force() * moving_.needle().direction(); }
    /// Place of its tip [m].
    core::Vector3 tip() const { return moving_.needle().entry + moving_.depth() * moving_.needle().direction(); }

  private:
    core::MovingNeedle moving_;
    double force_ = 0.0, tip_force_ = 0.0; ///< times the time of the steps since the last reading [N s]
    std::vector<core::Vector3> impulses_;  ///< (K) of the same steps [N s]
    double time_ = 0.0;                    ///< of these [s]
};

/// Whether two tools are one needle, however deep.
bool are_one_needle(const Tool &a, const Tool &b);

/// @throws support::InputError if the tool is a needle that is led to no depth
void check_depth(const Tool &tool);

/// @throws support::InputError if the tool is a needle that is none, leaves the body, or enters where nothing moves
void check_needle(const Tool &tool, const core::TetraMesh &mesh, const std::vector<bool> &is_constrained_node);

} // namespace livermark::live
