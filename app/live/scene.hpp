#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/live/find_cut.hpp"
#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "core/tool/ball_contact.hpp"
#include "core/tool/needle/needle.hpp"
#include "core/tool/stepper.hpp"
#include "msm/dynamics/spring_stepper.hpp"

namespace livermark::live {

/// Surface of a body that can be touched: boundary triangles that are not constrained.
struct Surface {
    std::vector<std::array<int, 3>> triangles; ///< (L) node numbers of the mesh, right-handed seen from outside
    std::vector<int> facet;                    ///< (L) which boundary triangles of the mesh these are
    std::vector<double> area;                  ///< (L) at rest [m^2]
    std::vector<int> nodes;                    ///< of these triangles, each once, ascending
};

/// @param is_constrained  shape (T), which boundary triangles cannot move
Surface touchable_surface(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained);

/// Forces of a tool on a body.
struct Load {
    std::vector<int> nodes{};                    ///< (K) that are loaded, each once
    std::vector<core::Vector3> nodal{};          ///< (K) forces on these [N]
    std::vector<int> triangles{};                ///< (L) of the surface that are loaded, each once
    std::vector<core::Vector3> facet{};          ///< (L) forces on these [N]
    core::Vector3 total = core::Vector3::Zero(); ///< [N]
    double pressed = 0.0; ///< sum of the sizes of the forces of its balls [N]: of one, and of a pull, that of the total
    /// Spread of the force of a pull, with the resultant `total`; radius 0 where it is even on each triangle.
    core::RoundLoad shape;
};

/// A small mass on a damped spring between the target, which jumps as a hand and a mouse do, and the body (virtual
/// coupling, Colgate, Stanley, Brown 1995, IROS): however rough the hand, what reaches the body is slow and not
/// stronger than the limit.
struct Proxy {
    core::Vector3 position = core::Vector3::Zero(); ///< [m]
    core::Vector3 velocity = core::Vector3::Zero(); ///< [m/s]
    core::Vector3 target = core::Vector3::Zero();   ///< where it is drawn to now [m]
};

/// Numbers of the virtual coupling: a metal probe that lies loosely in the hand.
inline constexpr double coupling_mass = 0.05;       ///< [kg]
inline constexpr double coupling_stiffness = 400.0; ///< [N/m]
inline constexpr double strongest_coupling = 12.0;  ///< [N]
inline constexpr double fastest_target = 0.5;       ///< [m/s]

/// Moves the target on, no faster than it may go.
void follow(Proxy &proxy, const core::Vector3 &target, double time_step);

/// One step of symplectic Euler.
/// @param force  of the body on the proxy [N]
void advance(Proxy &proxy, const core::Vector3 &force, double time_step);

/// Position of a node now, or another vector of it [m].
using PositionOf = std::function<core::Vector3(int node)>;

/// A point of the surface at rest.
struct Place {
    core::Vector3 point = core::Vector3::Zero();    ///< [m]
    core::Vector3 outwards = core::Vector3::Zero(); ///< normal of the surface there, of any length
    int triangle = -1;                              ///< of the surface, that the point is in
};

/// Place that a pull has hold of: forces are spread over it as those of the round tools of load cases
/// (core/load_case.hpp), so that a pull of one radius means the same on any mesh, and where it is now is the mean
/// with the same weights.
struct Disc {
    Place place;                ///< its middle
    core::RoundLoad shape;      ///< around that
    std::vector<int> triangles; ///< of the surface that it reaches, and that face the way of its middle
    std::vector<double> share;  ///< what each takes of a force on the disc; they add up to one
    std::vector<int> nodes;     ///< of these triangles, each once
    std::vector<double> weight; ///< what each takes, by linear shape functions; they add up to one
};

/// @param points  shape (N), at rest [m]
Place place_of_node(const Surface &surface, const std::vector<core::Vector3> &points, int node);

/// @param points  shape (N), at rest [m]
/// @return on the triangle of the place alone where it is too small for the mesh to be seen
Disc disc_around(const Surface &surface, const std::vector<core::Vector3> &points, const Place &place, double radius);

/// Mean of a nodal field over a disc.
core::Vector3 mean_over(const Disc &disc, const PositionOf &field);

/// Load of a force on a disc.
Load load_of(const Disc &disc, const core::Vector3 &force);

/// Body as a ball may touch it.
struct TouchableBody {
    core::Body body;                          ///< of the material that moves
    core::LoadCase load_case;                 ///< that constrains what cannot be touched
    std::vector<core::TouchedFacet> facets{}; ///< those of touchable_surface(), in its order
};

/// @param body            what is left of it
/// @param is_constrained  shape (T) of that
/// @param softness        of the springs
TouchableBody touchable_body(core::Body body, const std::vector<bool> &is_constrained,
                             const core::FacetSoftness &softness = {});

/// A rigid ball or plate that touches the surface with friction, by the law of load cases and of the arena
/// (core::BallContact). A hand comes from outside: put down in the body it begins on the surface. Where the centre of a
/// ball gets below the surface it touches nothing until it is nearly out again.
struct HeldBall {
    std::shared_ptr<core::BallContact> contact; ///< takes part in steps; null where there is no ball
    core::ToolShape shape;
    std::optional<double> depth{}; ///< by which it has sunk in, where that is led [m]; otherwise it is found
    int steps_to_look = 0;         ///< until facets around it are looked for again
    bool is_below = false;         ///< whether its centre is below the surface

    core::Vector3 force() const { return contact->force(); } ///< on the body in the last step [N]
    /// One of its own that goes on in the same way.
    HeldBall copy() const;
};

HeldBall take_ball(const TouchableBody &touchable, const core::ToolShape &shape, double friction);

/// Place for the centre of a ball where it does not reach into the body, near the one that was asked for [m].
core::Vector3 outside(const Surface &surface, double radius, const core::Vector3 &centre,
                      const PositionOf &position_of);

/// Place for the centre of a plate where it just touches or nearly, on its way to the one that was asked for [m].
/// @param plate  of which no other one knows
/// @throws support::InputError if that is further back than half a side
core::Vector3 before(const HeldBall &plate, const core::Vector3 &centre, const PositionOf &position_of);

/// Leads the ball with the proxy in the step to come.
/// @param from         where its centre was [m]
/// @param position_of, at_rest  of nodes [m]
void lead(HeldBall &ball, const Surface &surface, const Proxy &proxy, const core::Vector3 &from, double time_step,
          const PositionOf &position_of, const PositionOf &at_rest);

/// Forces of balls in the last step.
Load load_of(std::span<const HeldBall> balls, const Surface &surface);

/// Kinds of tools. The numbers are those of the messages.
enum class ToolKind {
    none = 0,
    probe = 1,  ///< a rigid ball or plate that follows the target and touches the surface with friction
    pull = 2,   ///< takes hold of the surface around a node, as a round tool does, and draws it to the target
    needle = 3, ///< goes from an entry towards a target inside, see core/tool/needle/moving_needle.hpp
    grasp = 4   ///< two balls that close against each other like the jaws of a forceps, and are led together
};

struct Tool {
    ToolKind kind = ToolKind::none;
    /// Place of the centre of the ball or plate, or of the node; or where a grasp is led to from its place [m].
    core::Vector3 target = core::Vector3::Zero();
    double radius = 0.012; ///< of the ball, or of the disc that is held, or half a side of the plate [m], > 0
    int node = 0;          ///< of the surface; looked at by a pull alone
    /// Coulomb's coefficient of a probe and of jaws, >= 0: that of load_cases/touching/large_touch.toml, so that a load
    /// case says the same.
    double friction = 0.3;
    core::Needle needle{}; ///< looked at by a needle alone, of which only `depth` changes
    double depth = 0.0; ///< of its tip below the entry at rest, or by which each jaw closes, as the hand leads it [m]
    core::Vector3 place = core::Vector3::Zero(); ///< of the surface as it was grasped [m]; looked at by a grasp alone
    /// Way from there to the other jaw, or axis of a plate, of any length.
    core::Vector3 inwards = core::Vector3::Zero();
    core::ToolFace face = core::ToolFace::ball; ///< of a probe
};

/// Radius of the edges of a plate over half its side: that of load cases that give none.
inline constexpr double edge_of_plate = 0.1;

/// Shape of a probe, or of each jaw.
core::ToolShape shape_of(const Tool &tool);

/// Whether two tools are one probe, wherever it is led.
bool are_one_probe(const Tool &a, const Tool &b);

/// Thickness of a body at most that jaws can be put around [m].
inline constexpr double widest_grasp = 0.06;
/// Speed at which each jaw closes or opens at most [m/s].
inline constexpr double fastest_jaw = 0.1;

/// Two balls that are each other's mirror image in a point: each closes towards it by the same way along an axis that
/// does not turn, as those of a load case with `jaws` do, and both are led with it. How far they close is prescribed,
/// and not what that takes; against the strongest coupling they close no further.
struct Jaws {
    core::Vector3 axis = core::Vector3::Zero();   ///< from the first one to the other, of length 1
    core::Vector3 middle = core::Vector3::Zero(); ///< the point, where both just touched [m]
    double apart = 0.0;                           ///< from there to the centres [m]
    double thickness = 0.0;                       ///< of the body between both [m], > 0
    /// Shape (T): which boundary triangles the other one touches, by where they faced when both were taken; they stay
    /// its own, so that no jaw ever touches what the other one has, however the body turns between them.
    std::vector<bool> is_for_other{};
    double depth = 0.0; ///< by which each has closed since [m]
    double speed = 0.0; ///< at which it does [m/s]

    /// Centre of the first one or of the other, where the point is at a place [m].
    core::Vector3 centre(std::size_t which, const core::Vector3 &point) const {
        return point + (which == 0 ? depth - apart : apart - depth) * axis;
    }
};

/// Jaws that just touch a body: the first where it is pressed, the other where the way inwards first leaves the body.
/// @param is_constrained  shape (T) of the mesh
/// @param position_of     of nodes [m]
/// @throws support::InputError if the place is not on the surface, or the body is too thick or constrained there
Jaws jaws_around(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained, const Tool &tool,
                 const PositionOf &position_of);

/// Whether two tools are one pair of jaws, wherever they are led.
bool are_one_grasp(const Tool &a, const Tool &b);

/// Two balls, each of which touches its own facets.
/// @param surface  of the body
std::vector<HeldBall> take_jaws(const TouchableBody &touchable, const Surface &surface, const Jaws &jaws, double radius,
                                double friction);

/// Closes or opens jaws for a step.
/// @param depth    that is asked for [m]
/// @param closing  force that each exerts along the axis [N]
void close(Jaws &jaws, double depth, double closing, double time_step);

/// Reading of a grasp.
struct GraspReading {
    double depth = 0.0;                                ///< by which each jaw has closed since both just touched [m]
    double closing = 0.0;                              ///< force of each on the body along the axis, their mean [N]
    core::Vector3 other = core::Vector3::Zero();       ///< centre of the other jaw [m]
    core::Vector3 other_force = core::Vector3::Zero(); ///< of the body on it [N]
};

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

    /// Acts on the tissue after a step that others have taken.
    /// @param depth  that the tool asks for [m]
    void act(core::Stepper &steps, double depth, double time_step);

    /// Means over the steps since the last reading.
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

/// Reason why steps may be no longer. The numbers are those of the messages.
enum class StepLimit {
    rest = 0,    ///< the body at rest
    pressed = 1, ///< a pressed body, in the parts of a divided step
    hand = 2     ///< the mass between the body and the hand
};

/// Steps that the settings come to: the one place where they are found.
struct Chosen {
    double time_step = 0.0;            ///< [s]
    double longest_time_step = 0.0;    ///< that may be asked for [s]
    double pressed_time_step = 0.0;    ///< that is not exceeded while a tetrahedron is pressed [s]
    double critical_time_step = 0.0;   ///< predicted, of symplectic Euler on the body at rest, with the masses of the
                                       ///< steps that are taken [s]
    double unscaled_time_step = 0.0;   ///< the longest while masses of stiff parts are as they are [s]
    StepLimit limit = StepLimit::rest; ///< of the longest
    int num_springs = 0;
};

/// A body after some steps with a tool.
struct Frame {
    double time = 0.0; ///< since the start [s]
    /// Centre of the probe, of a plate that of its flat, of what is pulled, or of the first jaw [m].
    core::Vector3 tool = core::Vector3::Zero();
    core::Vector3 force = core::Vector3::Zero(); ///< of the body on the tool, on both jaws together [N]
    /// Way by which the body yields in the mean over what the tool touches, weighted with what it exerts, along its
    /// force: sum of f_i . u_i / |sum of f_i| over the nodal forces [m]; what a load case with `press` prescribes.
    /// Under jaws it is over the sum of the sizes of both forces.
    double indentation = 0.0;
    double smallest_volume = 1.0; ///< of a tetrahedron, as a part of its volume at rest; below 0 it is inverted
    double largest_speed = 0.0;   ///< of all nodes, and of the tool [m/s]
    int restarts = 0;             ///< how often the motion has left all bounds and was set back to rest, as by reset()
    long num_evaluations = 0;     ///< of forces since the frame before: more than steps where some were divided
    std::vector<core::Vector3> displacement; ///< (N) [m]
    Load load;                               ///< of the tool on the body, in the last step
    const Surface *surface = nullptr;        ///< that the triangles of the load belong to
    std::optional<NeedleReading> needle;     ///< of a needle; its tip is `tool`
    std::optional<GraspReading> grasp;
};

/// Numbers of a cut that has been made.
struct CutReading {
    double volume = 0.0;             ///< that it has taken, at rest [m^3]
    double way_volume = 0.0;         ///< of the channel to the surface among that, at rest [m^3]
    double closed_volume = 0.0;      ///< of all closed cavities now, see ClosedCavities [m^3]
    double closed_depth = 0.0;       ///< of these below the surface [m]
    double wound_area = 0.0;         ///< of all cuts, at rest [m^2]
    double margin = 0.0;             ///< see FoundCut [m]
    OffBlade jagged, snapped;        ///< of a blade that has parted the body, see PartedBody
    int num_loose = 0;               ///< pieces that went because nothing holds them
    int num_pieces = 0;              ///< that are left
    double seconds_to_find = 0.0;    ///< which tetrahedra go
    double seconds_to_check = 0.0;   ///< how long steps may be
    double seconds_of_springs = 0.0; ///< from that to the next step
};

/// A soft body under somebody's hand: springs with or without a volume term, and with what the body has of capsule,
/// vessels and map of stiffness, on the springs of a foundation where there is one, in steps of symplectic Euler by the
/// fast kernels, and a tool that pokes, grasps, pulls or pricks. While a needle is in no masses are scaled, and steps
/// are divided where they would be too long then. The same calls give the same bits on every machine if the kernels do,
/// that is, in the portable build.
class Scene {
  public:
    /// @param is_constrained  shape (T), boundary triangles whose nodes never move
    /// @param foundation      below facets that are not constrained
    /// @param num_threads     that take the steps; what comes out does not depend on it
    /// @throws support::InputError if the body is not one that can move, or nothing is constrained, or nothing is free,
    ///   or the foundation is none
    Scene(core::Body body, const std::vector<bool> &is_constrained,
          const std::optional<core::Foundation> &foundation = {}, int num_threads = 1);

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

    /// Takes tetrahedra away from the body as it moves, or parts it, and the tool with it: what is left goes on from
    /// where it is, as fast as it was. Nodes keep their numbers; those that are gone stay where they are, and in frames
    /// they do not move. Where tetrahedra go, springs, means and masses are found again around the cut alone, as
    /// msm::CutParts does. A body that is parted gets new nodes behind the others, and some go to the blade, where they
    /// are at rest as well: its springs are set up anew. Capsule, vessels and foundation lose what goes, and steps are
    /// divided where they would be too long now.
    /// @throws support::InputError with nothing changed if nothing has been chosen, for what find_cut() refuses, and
    ///   for a cut that has been made already
    CutReading cut(const CutRequest &request);

    /// Remains that cuts have left.
    const Remains &remains() const { return remains_; }

    /// Constraints of its boundary triangles.
    std::vector<bool> constrained_remains() const { return live::constrained_remains(remains_, is_constrained_facet_); }

    /// Tetrahedra that cuts have taken, ascending.
    std::vector<int> gone() const;

    /// The mesh at rest before any blade has parted it.
    const core::TetraMesh &original_mesh() const;

    /// Node of the original mesh that each node is, or was parted from.
    const std::vector<int> &original_node() const { return original_node_; }

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

    /// The body at rest, whole but for what blades have parted.
    const core::Body &body() const { return body_; }

  private:
    std::optional<Jaws> checked_jaws(const Tool &tool) const;
    std::optional<core::Vector3> checked_place(const Tool &tool) const;
    void take_up(const Tool &tool, const std::optional<Jaws> &jaws = {},
                 const std::optional<core::Vector3> &place = {});
    void fit_tool();
    core::Vector3 within_reach(const core::Vector3 &goal) const;
    void step(const Tool &tool, double depth, double part);
    void put_needle(const Tool &tool);
    void prepare_steps(bool may_be_scaled);
    void cut_anew();
    void take_out(std::span<const int> tetrahedra);
    void divide_steps();
    void show_remains();
    TouchableBody touchable_remains() const;
    void undo_cuts(std::size_t num_left);
    void part(PartedBody parted);
    void move_parted(const std::vector<PlaceBefore> &before, const msm::State &state);
    void stand_on_foundation();
    std::vector<char> is_gone(std::size_t num_cuts) const;
    core::Vector3 force_on_tool() const;
    void draw(double part);
    void carry_load(double part);
    void lead_ball(double part);
    void lead_jaws(double depth, double part);
    double closing_force() const;
    void take_load_off();
    void let_touch();
    void touch_anew();
    core::Vector3 displacement(int node) const;
    bool is_lost(const msm::State &state) const;
    void settle();
    msm::State sound_state();
    Frame frame();

    struct Prepared; ///< what the settings came to, from which steps are prepared
    struct Unparted; ///< the body before it was parted

    struct MadeCut {
        meshes::CutTool tool;
        std::vector<int> tetrahedra;
        double critical_time_step;              ///< around its wound [s]
        std::shared_ptr<const Unparted> before; ///< null where nothing was parted
    };

    /// State that restore() goes back to.
    struct Moment {
        std::size_t num_cuts;
        msm::State state;
        Tool tool;
        Proxy proxy;
        Disc disc;
        std::vector<HeldBall> balls;
        std::optional<Jaws> jaws;
        std::vector<core::TouchedFacet> touched; ///< of balls
        Load load;
        int divided_steps;
        std::optional<HeldNeedle> needle;
    };

    core::Body body_;
    std::vector<int> original_node_;                     ///< (N)
    std::optional<core::Foundation> stands_on_;          ///< below the original facets
    std::vector<bool> is_constrained_;                   ///< (N)
    std::vector<bool> is_constrained_facet_;             ///< (T) of the whole body
    std::shared_ptr<const msm::ElasticTerm> foundation_; ///< below the whole body; null where there is none
    std::vector<bool> stands_; ///< (T) of the whole body, on springs that resist all directions
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
    std::vector<HeldBall> balls_; ///< of a probe, or of two jaws
    std::optional<Jaws> jaws_;
    std::optional<HeldNeedle> needle_;
    std::optional<Moment> kept_;
    double time_ = 0.0;
    int restarts_ = 0;
};

} // namespace livermark::live
