#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/live/contact.hpp"
#include "app/live/find_cut.hpp"
#include "app/live/needle.hpp"
#include "core/problem.hpp"
#include "msm/dynamics/spring_stepper.hpp"

namespace livermark::live {

/// The springs that are taken unless somebody chooses others: the most accurate ones. The page has the same name in
/// app/viewer/src/live/settings_panel.ts.
inline constexpr const char *usual_springs = "nodal_neo_hookean";

/// Choices while a body moves.
struct Settings {
    std::string springs = usual_springs; ///< of spring_names()
    bool keeps_volume = true;            ///< springs carry lambda = mu, a nodal volume term the rest
    double young_modulus = 0.0;  ///< of the region with the largest volume [Pa]; the others keep their ratio to it
    double poisson_ratio = 0.45; ///< of all regions, in [0, 0.49]; springs alone take no notice
    core::RayleighDamping damping{.alpha = 10.0, .beta = 0.0};
    double time_step = 0.0; ///< [s]; 0 takes the longest
};

/// Steps that the settings come to.
struct Chosen {
    double time_step = 0.0;          ///< [s]
    double longest_time_step = 0.0;  ///< that may be asked for [s]
    double pressed_time_step = 0.0;  ///< that is not exceeded while a tetrahedron is pressed [s]
    double critical_time_step = 0.0; ///< predicted, of symplectic Euler on the body at rest [s]
    int num_springs = 0;
};

/// A body after some steps with a tool.
struct Frame {
    double time = 0.0;                           ///< since the start [s]
    core::Vector3 tool = core::Vector3::Zero();  ///< centre of the probe, or of what is pulled [m]
    core::Vector3 force = core::Vector3::Zero(); ///< of the body on the tool [N]
    /// Way by which the body yields in the mean over what the tool touches, weighted with what it exerts, along its
    /// force: sum of f_i . u_i / |sum of f_i| over the nodal forces [m]; what a load case with `press` prescribes.
    double indentation = 0.0;
    double smallest_volume = 1.0; ///< of a tetrahedron, as a part of its volume at rest; below 0 it is inverted
    double largest_speed = 0.0;   ///< of all nodes, and of the tool [m/s]
    int restarts = 0;             ///< how often the motion has left all bounds and was set back to rest, as by reset()
    std::vector<core::Vector3> displacement; ///< (N) [m]
    Load load;                               ///< of the tool on the body, in the last step
    const Surface *surface = nullptr;        ///< that the triangles of the load belong to
    std::optional<NeedleReading> needle;     ///< of a needle; its tip is `tool`
};

/// Numbers of a cut that has been made.
struct CutReading {
    double volume = 0.0;             ///< that it has taken, at rest [m^3]
    double wound_area = 0.0;         ///< of all cuts, at rest [m^2]
    double margin = 0.0;             ///< see FoundCut [m]
    int num_loose = 0;               ///< pieces that went because nothing holds them
    int num_pieces = 0;              ///< that are left
    double seconds_to_find = 0.0;    ///< which tetrahedra go
    double seconds_to_check = 0.0;   ///< how long steps may be
    double seconds_of_springs = 0.0; ///< from that to the next step
};

/// A soft body under somebody's hand: springs with or without a volume term, in steps of symplectic Euler by the fast
/// kernels, and a tool that pokes, pulls or pricks. While a needle is in no masses are scaled, and steps are divided
/// where they would be too long then. The same calls give the same bits on every machine if the kernels do, that
/// is, in the portable build.
class Scene {
  public:
    /// @param is_constrained  shape (T), boundary triangles whose nodes never move
    /// @param num_threads     that take the steps; what comes out does not depend on it
    /// @throws support::InputError if the body is not one that can move, or nothing is constrained, or nothing is free
    Scene(core::Body body, const std::vector<bool> &is_constrained, int num_threads = 1);

    /// Takes other parameters, and goes on from where the body is.
    /// @throws support::InputError if there is no such law, or a number is out of its range
    Chosen choose(const Settings &settings);

    /// Takes steps.
    /// @param num_steps  0 ... 10000
    /// @throws support::InputError if nothing has been chosen, or the tool is no tool
    Frame move(const Tool &tool, int num_steps);

    /// The same for a hand that asks a thousand times in a second, and wants the force and nothing else.
    /// @return force of the body on the tool in the last step [N]; a motion that has left all bounds is set back by
    /// the next move()
    core::Vector3 feel(const Tool &tool, int num_steps);

    /// Number of times that forces have been evaluated since the scene was made: more often than steps were taken where
    /// something was pressed.
    long num_evaluations() const { return num_evaluations_; }

    /// Takes tetrahedra away from the body as it moves, and the tool with them: what is left goes on from where it is,
    /// as fast as it was. Nodes keep their numbers; those that are gone stay where they are, and in frames they do not
    /// move. Springs, means and masses are found again around the cut alone, as msm::CutParts does, and steps are
    /// divided where they would be too long now.
    /// @throws support::InputError with nothing changed if nothing has been chosen, for what find_cut() refuses, and
    /// for
    ///   a cut that has been made already
    CutReading cut(const CutRequest &request);

    /// Remains that cuts have left.
    const Remains &remains() const { return remains_; }

    /// Constraints of its boundary triangles.
    std::vector<bool> constrained_remains() const { return live::constrained_remains(remains_, is_constrained_facet_); }

    /// Tetrahedra that cuts have taken, ascending.
    std::vector<int> gone() const;

    /// Puts the body to where it is without loads, at rest and whole, and takes the tool away: from here on it moves to
    /// the last bit as a scene in which the same was chosen and nothing else was done. What was kept is forgotten.
    void reset();

    /// Keeps where the body is, how fast, and what the tool does to it. One state is kept, the last one.
    /// @throws support::InputError if nothing has been chosen
    void keep();

    /// Goes on from the state that was kept, with the parameters and the time of now: what has been cut since is there
    /// again.
    /// @throws support::InputError if none is kept
    void restore();

    const core::Body &body() const { return body_; }

  private:
    void take_up(const Tool &tool);
    void fit_tool();
    core::Vector3 within_reach(const core::Vector3 &goal) const;
    void step(const Tool &tool, double needle_depth, double part);
    void put_needle(const Tool &tool);
    void prepare_steps(bool may_be_scaled);
    void cut_anew();
    void take_out(std::span<const int> tetrahedra);
    void divide_steps();
    void show_remains();
    void undo_cuts(std::size_t num_left);
    std::vector<char> is_gone(std::size_t num_cuts) const;
    core::Vector3 force_on_tool() const;
    void draw(double part);
    void carry_load(double part);
    void lead_ball(double part);
    void take_load_off();
    void let_touch();
    void touch_anew();
    core::Vector3 displacement(int node) const;
    bool is_lost(const msm::State &state) const;
    void settle();
    msm::State sound_state();
    Frame frame();

    struct MadeCut {
        meshes::CutTool tool;
        std::vector<int> tetrahedra;
        double critical_time_step; ///< around its wound [s]
    };

    /// State that restore() goes back to.
    struct Moment {
        std::size_t num_cuts;
        msm::State state;
        Tool tool;
        Proxy proxy;
        Disc disc;
        HeldBall ball;
        std::vector<core::TouchedFacet> touched; ///< of the ball
        Load load;
        int divided_steps;
        std::optional<HeldNeedle> needle;
    };

    struct Prepared; ///< what the settings came to, from which steps are prepared

    core::Body body_;
    std::vector<bool> is_constrained_;       ///< (N)
    std::vector<bool> is_constrained_facet_; ///< (T) of the whole body
    Remains remains_;
    std::vector<int> gone_nodes_; ///< corners of nothing that is left
    Surface surface_;
    double extent_ = 0.0;    ///< diagonal of the box around the body [m]
    double mean_edge_ = 0.0; ///< [m]
    int num_threads_;
    std::map<std::string, core::SpringNetwork, std::less<>> springs_; ///< of each law, for the unit body

    std::shared_ptr<const Prepared> prepared_;
    std::unique_ptr<msm::SpringStepper> steps_; ///< of the whole body without what is gone
    std::vector<MadeCut> cuts_;
    bool are_scaled_ = false;        ///< whether the steps were prepared with scaled masses
    bool has_ended_scaling_ = false; ///< whether a cut since has ended that of a part
    double time_step_ = 0.0;         ///< [s]
    int num_parts_ = 1;              ///< of a step while something is pressed
    int fewest_parts_ = 1;           ///< of a step otherwise: more than one where masses are not scaled for a needle
    int divided_steps_ = 0;          ///< how many of the next steps are divided, because something was pressed
    long num_evaluations_ = 0;
    Tool tool_;
    Proxy proxy_;
    Disc disc_;                   ///< that a pull has hold of
    double grip_stiffness_ = 0.0; ///< between a pull and its disc [N/m]
    Load load_;                   ///< of a pull
    std::optional<TouchableBody> touchable_;
    HeldBall ball_; ///< of a probe
    std::optional<HeldNeedle> needle_;
    std::optional<Moment> kept_;
    double time_ = 0.0;
    int restarts_ = 0;
};

} // namespace livermark::live
