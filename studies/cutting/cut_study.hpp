#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/model.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"
#include "meshes/io/body_reader.hpp"
#include "results/records/cut.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

/// A blade that goes into a body in equal steps. It parts the body and takes nothing away.
struct BladeWay {
    /// In turn [m]. The blade's edge begins at 0-1 and ends at 3-2.
    std::array<core::Vector3, 4> corners;
    int num_steps = 20; ///< >= 1

    double depth() const; ///< how far the middle of the edge goes [m]
    /// Quadrilateral that the edge sweeps from one depth to another, as parts of the way.
    std::array<core::Vector3, 4> swept(double from, double to) const;
};

/// A body on the way.
struct CutStage {
    std::shared_ptr<const core::Body> body; ///< at rest
    double depth = 0.0;                     ///< of the blade's edge along its way [m]
    double area = 0.0;                      ///< cut so far, of one side, at rest [m^2]
    double seconds = 0.0;                   ///< that the last cut took
    /// (M) of each tetrahedron its number in the stage before; empty where the last step has parted nothing.
    std::vector<int> parents{};
    /// Nodes that were one before they were parted, two by two.
    std::vector<std::array<int, 2>> parted{};
};

/// Displacements of the nodes of a body when the blade goes on [m], asked for before each step.
using DisplacementOf = std::function<std::vector<core::Vector3>(const CutStage &stage)>;

/// Divides a body along facets, step by step. The blade is where it is in space, and meets the body as that is then; a
/// step on which it parts no face changes nothing.
/// @param displacement_of  nothing for a body that stays at rest
/// @return num_steps + 1, the first as the body was
/// @throws support::InputError   for a blade that is none
/// @throws meshes::CutNotOnBody  if no step parts anything, or the body falls apart
std::vector<CutStage> grow_cut(std::shared_ptr<const core::Body> body, const BladeWay &way,
                               const DisplacementOf &displacement_of);

/// The same body with all of the blade's way cut in one step, exactly: tetrahedra are split at it. It ends at a face,
/// up to an edge short of the end of the way.
/// @throws meshes::CutNotOnBody  if it parts nothing, or the body falls apart
CutStage cut_exactly(const core::Body &body, const BladeWay &way);

/// Distance of the two sides of a cut where they are furthest apart [m].
double opening(const CutStage &stage, const std::vector<core::Vector3> &displacement);

/// Stiffness where the body is touched, core::stiffness_at() the first tool [N/m]; NaN without one.
double stiffness_at_first_tool(const core::Problem &problem, const core::Solution &solution);

/// Nodes of the edges at which a cut ends inside the body: there the two sides of the wound meet, and have the material
/// around them. Stresses are singular there.
/// @return (N)
std::vector<bool> wound_rim_nodes(const core::TetraMesh &mesh);

/// Solves a model on a cut body, and on meshes that are finer and finer: tetrahedra at the rim of the wound and at the
/// rims of the places of the load case have all their edges cut in two, again and again. Openings are at the nodes of
/// the coarsest mesh. What has no equilibrium ends it.
/// @param way      of the blade
/// @param cut      for CutLevel::way
/// @param problem  on the body of the stage
/// @param times    how often meshes are refined
/// @param begins   called before each mesh
/// @return times + 1 levels, or fewer; the message of the level that has no equilibrium is in failure
std::vector<results::CutLevel> solve_finer_at_wound(const core::Model &model, const BladeWay &way,
                                                    const std::string &cut, const CutStage &stage,
                                                    const core::Problem &problem, int times,
                                                    const std::function<void()> &begins, std::string &failure);

/// Which methods move a body while a blade goes on.
struct CutMotionOptions {
    std::vector<std::string> methods;                      ///< none if there are none; "all" for all
    std::vector<double> budgets{0.001, 0.004, 1.0 / 60.0}; ///< of one core, for a frame [s]
    int frames_per_step = 6;                               ///< of the blade
};

/// Their names, in the order of the table.
/// @throws support::InputError for one that is none, and for budgets or frames that are not above 0
std::vector<std::string> chosen_methods_under_blade(const CutMotionOptions &options);

/// @throws support::InputError if some directions of a node are constrained and others are not, or a place is displaced
void check_loads_of_motion(const core::Problem &problem);

/// Frames in which a body comes to rest, before the blade and after it.
inline constexpr int frames_to_rest = 120;

/// Moves methods under constant loads while a blade goes on: from rest, frames_to_rest frames in which the body comes
/// to its place, then for each stage the cut and frames_per_step frames, then frames_to_rest. Within each budget a
/// method takes one step in a frame with as many iterations as fit, and as many steps as fit of ten iterations and of
/// one: models::all_settings. Methods with a least number of steps take that, or twice that if they diverge, and have
/// one run, with the smallest budget that it fits into, or the largest.
/// @param stages    of grow_cut()
/// @param problems  the loads on each of them, which pass check_loads_of_motion()
/// @return method by method, and budget by budget
std::vector<results::CutMotion> move_under_blade(const CutMotionOptions &options, const std::vector<CutStage> &stages,
                                                 const std::vector<core::Problem> &problems,
                                                 const ProgressReport &report);

/// Options of `livermark cut`.
struct CutStudyOptions {
    std::string body = "liver_healthy"; ///< name or path
    std::string load_case = "traction"; ///< name or path
    std::vector<std::string> models;    ///< beside the reference on the mesh; all that run by default if there are none
    std::vector<double> blade;          ///< four corners in turn, twelve numbers; its edge goes from 0-1 to 3-2 [m]
    int num_steps = 20;
    double toughness = 164.0; ///< [J/m^2]
    /// Regime of the models that are compared: of a load case of the small regime the large one may be asked for. That
    /// of the load case if not set.
    std::optional<core::Regime> regime;
    int num_refined = 2; ///< how often the reference is refined at the rim of the wound in the end: 0, or 2 and more
    CutMotionOptions motion; ///< of methods that move meanwhile
    meshes::MaterialOverride material;
    std::string output; ///< folder for <body>/cut.<load case>.h5, or cut.<load case>.large.h5 for another regime
};

struct CutResults {
    results::CutFile file;
    std::vector<std::string> notes; ///< what a user should know of input and result, a sentence each
};

/// Lets a blade go into a body under the loads of a load case, in steps: divide, find the equilibrium of what is left
/// under the same loads, and divide further. All models solve the same bodies, so the reference on the mesh tells their
/// errors. Under a load case of the small regime the blade meets the body as it is at rest, also where models of the
/// large one are compared; under one of the large regime where the reference has moved it to. Cuts go along facets. In
/// the end the reference is solved on finer meshes of the cut body too, and where the blade meets the body at rest on
/// those of the exact cut.
///
/// Loads keep their size and direction while the blade goes on, so what a step sets free is the work of the loads in
/// it less what more is stored. Where a model other than the reference finds no equilibrium its records are NaN.
/// Methods that move go on from one cut body to the next, which are those of the reference; only under a load case of
/// the small regime, where the blade meets the body as it is at rest.
/// @throws support::InputError for bad input: a load case that is none of constant loads, a blade that misses, a body
///         that falls apart, a model that takes no part, no equilibrium of the reference
CutResults let_blade_in(const CutStudyOptions &options, const std::string &command_line, const ProgressReport &report);

} // namespace livermark::studies
