#pragma once

#include <filesystem>
#include <string>

#include "core/load_case.hpp"

namespace livermark::load_cases {

/// The one-line title of a load case.
/// @throws support::InputError
std::string load_case_title(const std::filesystem::path &toml_file);

/// What decides whether a load case runs at all.
struct LoadCaseKind {
    core::Regime regime;
    bool depends_on_time; ///< has a release or a slow history
    bool moves_tool = false;
    bool has_needle = false; ///< see read_needles()
};

/// @throws support::InputError
LoadCaseKind load_case_kind(const std::filesystem::path &toml_file);

/// Reads a load case and puts it on a mesh.
///
///     title = "what a surgeon or engineer recognises"  # the name of the file if this is left out
///     regime = "large"                        # surgical size, judged by hyperelasticity; or "small", as it is if
///                                             # this is left out
///     path = [0.2, 0.4, 0.6, 0.8, 1.0]        # of a large one: parts of the loads at which solutions are stored;
///                                             # may be left out
///     target_peak_displacement = 0.002        # [m]; if it is left out as far as places are moved, or where forces
///                                             # alone act a hundredth of the size of the body
///     scale_to_target = true                  # may be left out: what drives is multiplied until the linear baseline
///                                             # reaches the target; that is for who solves, not done here
///     acceleration = [0.0, 0.0, 0.0]          # [m/s^2], may be left out
///     [[condition]]                           # where: one of the keys of selectors/, such as
///     patch = "posterior"                     #     disc = { patch = "anterior", radius = 0.01 }, which say what they
///     displacement = [0.0, 0.0, 0.0]          #     take; what: one of
///     name = "vena cava"                      # of the place in reactions, may be left out
///
///     displacement = [x, y, z]                # [m], with "free" components
///     push = d                                # the whole place moves by d [m] against its mean outward normal
///     press = d                               # a traction against the mean outward normal, as large as it takes to
///                                             # move the body there by d [m], in the mean weighted with the traction;
///                                             # nothing is held
///     press_along = [x, y, z]                 # [m], the same along this way
///     traction = [x, y, z]                    # [Pa]
///     tangential_traction = [x, y, z]         # [Pa], its part along the surface
///     force = [x, y, z]                       # [N], the same traction on the whole place, with this resultant
///     tangential_force = [x, y, z]            # [N], tractions along the surface, with this part of their resultant
///                                             # along the given direction
///     pressure = p                            # [Pa], pushes inwards
///     follower_pressure = p                   # [Pa], the same, and stays perpendicular to the surface as that moves;
///                                             # in the large regime
///     torque = [x, y, z]                      # [N m], tractions about the middle of the place without a resultant
///
/// A time-dependent load case starts from the static solution to all this; at t = 0 its tractions and pressures are let
/// go:
///
///     [release]
///     duration = 1.2                          # [s], a whole number of
///     output_interval = 0.004                 # [s]
///     damping_ratio = 0.05                    # at these two frequencies [Hz], less between them and more outside;
///     damping_frequencies = [1.7, 10.0]       # or instead alpha [1/s] and beta [s] of D = alpha M + beta K
///     [[probe]]                               # one or more
///     name = "tip"
///     patch = "left_lobe_tip"                 # the node in the middle of it
///
/// In a load case with a tool, one place presses, slides and lets go, and the other places hold:
///
///     [tool]
///     place = "fingertip"                     # the name of a condition with a displacement
///     press_until = 0.5                       # [s], from t = 0 to its displacement
///     slide = [0.01, 0.0, 0.0]                # [m], of the whole place beside that; none if this is left out,
///     slide_from = 0.6                        # [s], between these two times; from press_until
///     slide_until = 1.0                       # to release_at if they are left out
///     release_at = 1.1                        # [s], when the place is free again
///     duration = 1.6                          # [s], whole numbers of frames both
///     frame_rate = 60.0                       # [1/s], as it is if this is left out
///     mass_damping = 7.0                      # alpha [1/s] of D = alpha M
///     radius = 0.02                           # [m], of the ball that touches in `livermark arena --tool touching`
///
/// Where time passes in the material, the deviatoric stress of the elastic law fades with a Prony series, and all loads
/// and displacements grow from nothing as slowly as is said, so that masses do not matter:
///
///     [history]
///     relaxation = "liver_perfused"           # a file of load_cases/relaxation/, or a path to another one; or
///                                             # { moduli = [0.3, 0.3], times = [1.86, 51.3] }: parts of the shear
///                                             # modulus, and times [s]
///     press = 1.0                             # [s], linearly to the whole load
///     hold = 60.0                             # [s], as it is; may be left out, like the next two
///     release = 1.0                           # [s], linearly back to nothing
///     rest = 30.0                             # [s], after that
///     frequency = 1.0                         # [Hz], or instead of these four: the load is (1 - cos(2 pi f t)) / 2
///     cycles = 5                              # of what it is, so often
///
/// A rigid ball may touch a body that is held elsewhere, in the large regime; it does not stick to it:
///
///     [touch]
///     disc = { patch = "anterior", radius = 0.012 } # or another place: the ball comes against its mean normal,
///                                             # over the point of it that is nearest to its middle
///     radius = 0.012                          # [m], of the ball
///     depth = 0.01                            # [m], on from where the ball just touches the body at rest
///     friction = 0.3                          # Coulomb's coefficient; 0 if this is left out
///     slide = [0.01, 0.0, 0.0]                # [m], after that; none if this is left out. The first half of the path
///                                             # presses then
///
/// What it exerts is the reaction "touch".
///
/// A body may be cut at rest before anything is done to it: [[cut]], of which meshes/cutting/cut_reader.hpp says what
/// it takes. The mesh here is that of the cut body, with its patch "wound".
///
/// The area of the facets of a disc is not that of the disc, so its tractions are multiplied by the ratio of the two:
/// the resultant is the same on every mesh. All places that press are one instrument, such as the jaws of a forceps:
/// their depth is one, and so is the size of their forces. They drive the body alone. With profile = "round" in a disc
/// the tool has a round end (round_tool.hpp): displacements are largest in its middle and half of that at its rim,
/// pressures and tractions vanish at its rim, and what is given is their mean.
///
/// Where a body is narrow, a place yields to those above it: see place_apart(). What it lost is LoadCase::yielded.
/// @throws support::InputError with file, line and remedy: not TOML, unknown keys, a body that is not constrained, or
///         not cut where it should be, nothing to scale, a release without tractions or probes; NotOnBody
///         (load_cases/places/selector.hpp) for what this body has no place for: a patch or region that it lacks, a
///         place that no facet is in, places of which less than three quarters are left beside those above, a body that
///         is free to move as a whole, a probe that is constrained
core::LoadCase read_load_case(const std::filesystem::path &toml_file, const core::TetraMesh &mesh);

/// The same from text. The file gives the name of the load case, and the place in messages.
core::LoadCase parse_load_case(const std::string &text, const std::filesystem::path &file, const core::TetraMesh &mesh);

} // namespace livermark::load_cases
