#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "meshes/io/body_reader.hpp"
#include "results/hdf5/references.hpp"
#include "results/records/arena.hpp"
#include "results/records/needle.hpp"
#include "studies/models/motion/moving_method.hpp"
#include "studies/run/run.hpp"
#include "studies/study.hpp"

/// Load cases with a tool, and the meshes of an arena.
namespace livermark::studies {

/// Whether a load case is one of load_cases/moving/, or the path of one with a [tool].
bool moves_tool(const std::string &load_case);

/// Bodies under such a load case.
/// @throws support::InputError
ProblemSet read_arena_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                               const meshes::MaterialOverride &material = {});

/// A problem on a mesh of an arena.
/// @param mesh  1 as it is, 2 with the longest edge of each tetrahedron bisected, 3 with each tetrahedron cut into
///              eight
core::Problem on_arena_mesh(const core::Problem &problem, int mesh);

/// Interactive methods constrain whole nodes.
/// @throws support::InputError if a place of the load case leaves a component of its displacement free
void refuse_single_components(const core::LoadCase &load_case);

/// Effort of the reference of motions under a tool.
struct ToolReferenceOptions {
    int level = 2; ///< of refinement at the rims of places, at least 1
    int steps_per_frame = 4;
};

/// The reference that is stored; nothing if none is.
std::optional<results::ToolReference> find_tool_reference(const core::Problem &problem);

/// A coarse one in minutes, for a body that has none: quadratic tetrahedra on the mesh as it is, in two steps a frame.
/// Its own error is not known (NaN). It is kept at the path, and read from there if it is that of the problem.
/// @param starting  called before it is solved
/// @throws support::InputError where the motion finds no next step, and where the path cannot be written
results::ToolReference coarse_tool_reference(const core::Problem &problem, const std::filesystem::path &path,
                                             const std::string &command_line,
                                             const std::function<void(const std::string &)> &starting);

/// Grip of the tool on a body.
enum class ArenaTool : std::uint8_t {
    glued,    ///< it has hold of the nodes of its place
    touching, ///< it is a ball that touches, see load_cases::with_touching_ball()
    needle    ///< it is driven in and drawn out: see run_needle_arena(), which run_arena() is not for
};

/// Options of `livermark arena`.
struct ArenaOptions {
    std::vector<std::string> bodies;
    std::string load_case = "press_and_slide"; ///< of load_cases/moving/, or a path
    std::vector<std::string> methods;          ///< all if there are none
    /// Meshes: 1 as they are, 2 with the longest edge of each tetrahedron bisected, 3 with each
    /// tetrahedron cut into eight.
    std::vector<int> meshes{1, 2, 3};
    std::vector<double> budgets{0.001, 0.004, 1.0 / 60.0}; ///< of one core, for a frame [s]
    /// Numbers of iterations in a frame that methods move with as well, whatever time these take: as iterations of one
    /// step, and as steps of one iteration. What takes explicit steps takes its least number of them, and twice that.
    std::vector<int> iterations;
    ArenaTool tool = ArenaTool::glued;
    double friction = 0.0; ///< of a ball that touches
    meshes::MaterialOverride material;
    std::string output; ///< folder for <body>/arena.h5, or for <body>/arena_touching_<friction>.h5
};

/// An arena without runs yet.
/// @param reference  null if there is none
results::Arena empty_arena(const core::Problem &problem, const results::ToolReference *reference,
                           const std::string &command_line);

/// Moves methods under the tool of a load case, within each budget, on each mesh, compares them with the stored
/// reference motion, and writes <output>/<body>/arena.h5. Under a ball that touches, methods that know no contact are
/// left out, which the notes say, and where no reference is stored there are forces and no errors.
/// @throws support::InputError for bad input, where no reference of a glued tool is stored, where a method that was
///         asked for knows no contact, and where a file cannot be written
Found<results::Arena> run_arena(const ArenaOptions &options, const std::string &command_line,
                                const ProgressReport &report);

/// Solves the reference motions of these bodies and stores them: on the mesh as it is, on the finest one and on the one
/// before, and with half the steps on the first, which takes minutes to an hour.
/// @return one of each body
/// @throws support::InputError also where the tool touches: no reference motion knows contact
std::vector<results::ToolReference> solve_arena_references(const ArenaOptions &options,
                                                           const ToolReferenceOptions &reference,
                                                           const std::string &command_line,
                                                           const ProgressReport &report);

/// A needle and a body on one of the meshes of an arena.
struct NeedleScene {
    const core::Problem &problem;
    const core::Needle &needle;
    models::NeedlePlan plan;
    const results::NeedleArena &arena;                  ///< with what the reference meets
    const std::vector<core::Vector3> &reference_places; ///< (K) displacement of the places at the plan [m]
};

/// The arena of a needle without runs: what the static needle meets at the depths of a plan.
/// @param reference  of the needle on finer meshes
/// @param coarser    the same on the mesh before; null if there is none
results::NeedleArena empty_needle_arena(const core::Needle &needle, const models::NeedlePlan &plan,
                                        const core::Insertion &reference, const core::Insertion *coarser);

/// A method with all budgets and settings on one mesh. What has no choice of its effort moves once, or twice where its
/// steps have to be halved.
std::vector<results::NeedleArenaRun> run_needle_budgets(const models::MovingMethod &method, const NeedleScene &scene,
                                                        const std::vector<double> &budgets);

/// Beside ArenaOptions, what `livermark arena --tool needle` was asked for. Its load case is one of
/// load_cases/needles/, or a path.
struct NeedleArenaOptions {
    std::vector<std::string> needles; ///< names of needles of the load case; all if there are none
    double speed = 0.02;              ///< of the hand [m/s]
    double rest = 0.5;                ///< at the target [s]
    bool reference_on_mesh = false;   ///< judged by the mixed elements on the mesh itself
};

/// Leads the needles of a load case into bodies that methods move, within each budget, on each mesh, compares them with
/// the static needle in the reference at the same depths, and writes <output>/<body>/needle_arena.<load case>.h5.
/// Insertion by centimetres in a second is slow for tissue, so no reference moves.
/// @throws support::InputError for bad input, for a method that was asked for and holds no needle, and where a file
///         cannot be written
/// @return of each body each needle with its reference and an arena
Found<results::NeedleFile> run_needle_arena(const ArenaOptions &options, const NeedleArenaOptions &needle_options,
                                            const std::string &command_line, const ProgressReport &report);

} // namespace livermark::studies
