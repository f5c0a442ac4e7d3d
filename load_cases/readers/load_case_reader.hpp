#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"
#include "core/tool/needle/needle.hpp"

namespace livermark::load_cases {

/// The one-line title of a load case.
/// @throws support::InputError
std::string load_case_title(const std::filesystem::path &toml_file);

/// The command that solves a load case in which nothing happens that has a command of its own.
inline constexpr std::string_view run_command = "run";

/// Properties that decide whether a load case runs at all.
struct LoadCaseKind {
    core::Regime regime;
    bool depends_on_time = false;             ///< whether time passes after the static start or in the material
    std::vector<std::string_view> commands{}; ///< of the program, that solve it; the first one is named in messages
    std::string_view what{};                  ///< why, such as "has a needle"; empty for run_command

    bool is_for(std::string_view command) const;
};

/// @throws support::InputError
LoadCaseKind load_case_kind(const std::filesystem::path &toml_file);

/// Reads a load case and puts it on a mesh. Only conditions are required; defaults are in parentheses.
///
///     title = "what a surgeon or engineer recognises"  # (the name of the file)
///     regime = "large"                        # reference: hyperelasticity; or "small": linear elasticity ("small")
///     path = [0.2, 0.4, 0.6, 0.8, 1.0]        # in the large regime: parts of the loads at which solutions are stored
///     target_peak_displacement = 0.002        # [m] (the largest prescribed displacement; under forces alone a
///                                             # hundredth of the size of the body)
///     scale_to_target = true                  # whoever solves multiplies loads and displacements until the linear
///                                             # baseline reaches the target (false); this reader does not
///     unit = "mm"                             # of all lengths in this file: "m", "cm", "mm" or a number of metres
///                                             # ("m"); all else is in SI units
///     acceleration = [0.0, 0.0, 0.0]          # [m/s^2] (zero)
///     [[condition]]                           # a place, and what happens there
///     patch = "posterior"                     # the place: a key of load_cases/selectors/, such as
///                                             # disc = { patch = "anterior", radius = 0.01 }
///     displacement = [0.0, 0.0, 0.0]          # what happens: one of the keys below
///     name = "vena cava"                      # of the place in reactions
///
///     displacement = [x, y, z]                # [m], with "free" components
///     push = d                                # [m], displacement of the whole place against its mean outward normal
///     press = d                               # [m], depth to which a traction against the mean outward normal
///                                             # presses, in the mean weighted with the traction; constrains no node
///     press_along = [x, y, z]                 # [m], the same in this direction
///     traction = [x, y, z]                    # [Pa]
///     tangential_traction = [x, y, z]         # [Pa], its part along the surface
///     force = [x, y, z]                       # [N], resultant of a uniform traction on the whole place
///     tangential_force = [x, y, z]            # [N], component of the resultant of tractions along the surface
///     pressure = p                            # [Pa], pushes inwards
///     follower_pressure = p                   # [Pa], the same, and stays perpendicular to the moving surface; in the
///                                             # large regime
///     torque = [x, y, z]                      # [N m], of tractions about the middle of the place without a resultant
///
/// A time-dependent load case starts from the static solution. At t = 0 its tractions and pressures become zero:
///
///     [release]
///     duration = 1.2                          # [s], a multiple of output_interval
///     output_interval = 0.004                 # [s]
///     damping_ratio = 0.05                    # at these two frequencies, less between them and more outside;
///     damping_frequencies = [1.7, 10.0]       # [Hz]; or alpha [1/s] and beta [s] of D = alpha M + beta K
///     [[probe]]                               # one or more
///     name = "tip"
///     patch = "left_lobe_tip"                 # the node in its middle
///
/// In a load case with a tool, one place presses, slides and lets go; the other places stay constrained:
///
///     [tool]
///     place = "fingertip"                     # the name of a condition with a displacement
///     press_until = 0.5                       # [s], from t = 0 to its displacement
///     slide = [0.01, 0.0, 0.0]                # [m], added to it while it slides (none)
///     slide_from = 0.6                        # [s] (press_until)
///     slide_until = 1.0                       # [s] (release_at)
///     release_at = 1.1                        # [s], from then on the place is free
///     duration = 1.6                          # [s]; this and release_at are whole numbers of frames
///     frame_rate = 60.0                       # [1/s] (60)
///     mass_damping = 7.0                      # alpha [1/s] of D = alpha M
///     radius = 0.02                           # [m], of the ball that touches in `livermark arena --tool touching`
///                                             # (or a plate with the keys of a [touch])
///
/// In tissue that relaxes, the deviatoric stress of the elastic law falls with a Prony series. All loads and
/// displacements grow so slowly that inertia is neglected:
///
///     [history]
///     relaxation = "liver_perfused"           # a file of load_cases/relaxation/, a path, or
///                                             # { moduli = [0.3, 0.3], times = [1.86, 51.3] }: parts of the shear
///                                             # modulus, and times [s]
///     press = 1.0                             # [s], linearly to the whole load
///     hold = 60.0                             # [s], at the whole load (none)
///     release = 1.0                           # [s], linearly back to zero (none)
///     rest = 30.0                             # [s], at zero, after a release (none)
///     frequency = 1.0                         # [Hz], in place of these four: the load is (1 - cos(2 pi f t)) / 2
///     cycles = 5                              # number of periods
///
/// With a [release] as well, tractions are let go where the history ends, and the body moves and relaxes. Its history
/// has 'press' and 'hold' then, in the small regime.
///
/// A rigid ball or plate may touch a body that is held elsewhere, in the large regime; it does not stick to it:
///
///     [touch]
///     disc = { patch = "anterior", radius = 0.012 } # or another place: the ball comes against its mean normal,
///                                             # over the point of it that is nearest to its middle
///     radius = 0.012                          # [m], of the ball
///     depth = 0.01                            # [m], on from where the ball just touches the body at rest
///     friction = 0.3                          # Coulomb's coefficient; 0 if this is left out
///     slide = [0.01, 0.0, 0.0]                # [m], after that; none if this is left out. The first half of the path
///                                             # presses then
///     jaws = true                             # a second ball comes from the other side of the body and sinks in as
///                                             # deep, as the jaws of a forceps close; without a slide
///
/// In place of the radius, a plate has:
///
///     plate = "round"                         # or "square", of the face; its axis is the direction of the press
///     size = 0.012                            # [m], of the flat face: its radius, or half of a side
///     edge_radius = 0.0012                    # [m], of the rounding beside it, a tenth of the size if this is left
///                                             # out; flanks follow, so a plate is as thick as it is deep in the body
///
/// It starts where its face or its edge first touches the body at rest. Two sides of a square are as near to an axis of
/// coordinates of the mesh as they can be.
///
/// What it exerts is the reaction "touch", and what the other jaw exerts "other jaw".
///
/// A place may stand on elastic springs beside what else acts, as ligaments and the diaphragm bear a liver. Something
/// else still constrains the body:
///
///     [foundation]      # or several, each a [[foundation]]; a facet in two of them has the springs of the first
///     patch = "posterior"                     # or another place, less what conditions constrain
///     stiffness = 1e5                         # [N/m^3], k in the traction -k u on the body, on areas at rest
///     normal_only = true                      # whether it resists motion along the normal at rest alone (false)
///
/// The force of its springs is no reaction: it is what reactions and loads leave.
///
/// A body may be cut at rest before the load case: [[cut]], see meshes/cutting/cut_reader.hpp. The mesh here is that of
/// the cut body, with its patch "wound".
///
/// Vectors of a load case that names a patch of the liver are those of the patient: x to the left, y posterior, z
/// superior (LPS). Where a run lays the load case on a liver with other axes, they turn with it: accelerations, all
/// vectors of a condition, the 'direction' of a disc and 'slide'. A load case without such a patch has the axes of the
/// mesh, and so has every body that is no liver; 'axes' in the .toml of a body sets others for all load cases. Points
/// are places in the mesh and do not turn: those of a disc, of a needle and of a [[cut]], with the normals of the cut.
///
/// The facets of a disc do not have its area, so its tractions are multiplied by the ratio of the two areas: the
/// resultant is the same on every mesh. All places that press are one instrument, such as the jaws of a forceps, with
/// one depth and one size of their forces. They alone drive the body. With profile = "round" in a disc the tool has a
/// round end (effects.cpp): displacements are largest in its middle and half of that at its rim, pressures and
/// tractions vanish at its rim, and the given value is their mean.
///
/// Two places may claim the same facet where a body is narrow. The place that is written first gets it; the later one
/// keeps its other facets. If these have less than three quarters of its area, the load case does not fit the body.
/// @throws support::InputError with file, line and remedy: not TOML, unknown keys, a body that is not constrained, or
///         not cut where it should be, nothing to scale, a release without tractions or probes; NotOnBody
///         (load_cases/places/selector.hpp) for what this body has no place for: a patch or region that it lacks, a
///         place that no facet is in, places of which less than three quarters are left beside those above, a body that
///         is free to move as a whole, a probe that is constrained
core::LoadCase read_load_case(const std::filesystem::path &toml_file, const core::TetraMesh &mesh);

/// The same from text. The file gives the name of the load case, and the place in messages.
core::LoadCase parse_load_case(const std::string &text, const std::filesystem::path &file, const core::TetraMesh &mesh);

/// Both on a body: directions are turned with it first (turn_directions()).
core::LoadCase read_load_case(const std::filesystem::path &toml_file, const core::Body &body);
core::LoadCase parse_load_case(const std::string &text, const std::filesystem::path &file, const core::Body &body);

/// A load case in which a ball moves as its tool does: it touches the place that the tool has hold of otherwise, and
/// that is free. The ball has the radius that the [tool] says, comes the way that the place is pushed, through the
/// centroid of the place (weighted with how far it is pushed), and begins where it just touches the body at rest.
/// @param load_case  with a tool, as it was read on the mesh
/// @param friction   Coulomb's coefficient, >= 0
/// @throws support::InputError if the [tool] has no radius, or if the place is pushed nowhere
core::LoadCase with_touching_ball(core::LoadCase load_case, const core::TetraMesh &mesh, double friction);

/// Reads the needles of a load case, whose lengths are in its 'unit', and puts them on a body. Its conditions hold the
/// body, and nothing else acts.
///
///     [[needle]]
///     name = "to the largest"        # in tables and files
///     entry = "anterior"             # a patch: of its surface the point that is nearest to the target; or
///                                    # [x, y, z] [m], moved to the nearest point of the surface
///     target = "tumour_1"            # the centroid of a region, or [x, y, z] [m]; or instead
///     depth = 0.06                   # [m], below the middle of the patch, against its normal there
///     diameter = 0.00127             # [m]
///     spread = 0.006                 # [m], radius of the places that forces are spread over: that of the needle or
///                                    # more, and no less than core::smallest_spread()
///     toughness = 164.0              # [J/m^2], see core::Needle
///     friction = 20.0                # [N/m]
///     puncture_force = 1.4           # [N]; what tearing takes if it is left out: a nick was made first
///     side_stiffness = 1e5           # [N/m^2], of each metre of the shaft, which holds the tissue across the axis;
///                                    # rigid if it is left out, and as good as not held at 1
///     step = 0.0005                  # [m], may be left out
///
/// @param toml_file   the load case
/// @param load_case   the same, put on the mesh of the body
/// @return one or more
/// @throws support::InputError with file, line and remedy: nothing is driven in, numbers out of range, an entry that is
///   held or no surface, a target outside, a way that leaves the body, two needles of one name or one way; NotOnBody
///   for a patch or region that this body lacks
std::vector<core::Needle> read_needles(const std::filesystem::path &toml_file, const core::Body &body,
                                       const core::LoadCase &load_case);

} // namespace livermark::load_cases
