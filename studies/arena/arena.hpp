#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "models/tool_motion/moving_method.hpp"
#include "results/records/arena.hpp"
#include "studies/arena/arena_reference.hpp"
#include "studies/progress.hpp"
#include "studies/run/problems.hpp"

namespace livermark::studies {

/// How the tool moves a body.
enum class ArenaTool : std::uint8_t {
    glued,    ///< it has hold of the nodes of its place
    touching, ///< it is a ball that touches, see load_cases::with_touching_ball()
    needle    ///< it is driven in and drawn out: see run_needle_arena(), which run_arena() is not for
};

/// What `livermark arena` was asked for.
struct ArenaOptions {
    std::vector<std::string> bodies;
    std::string load_case = "press_and_slide"; ///< of load_cases/moving/, or a path
    std::vector<std::string> methods;          ///< all if there are none
    /// How fine the meshes are: 1 as they are, 2 with the longest edge of each tetrahedron bisected, 3 with each
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

struct ArenaResults {
    std::vector<results::Arena> of_body;
    std::vector<std::string> notes; ///< what a user should know of the bodies, a sentence each
};

/// Names of load_cases/moving/.
std::vector<std::string> moving_load_cases();

/// Whether a load case is one of these, or the path of one with a [tool].
bool moves_tool(const std::string &load_case);

/// Bodies under a load case of moving_load_cases(), or of a path.
/// @throws support::InputError
ProblemSet read_arena_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                               const meshes::MaterialOverride &material = {});

/// An arena without runs yet.
/// @param reference  null if there is none
results::Arena empty_arena(const core::Problem &problem, const results::ToolReference *reference,
                           const std::string &command_line);

/// Moves methods under the tool of a load case, within each budget, on each mesh, compares them with the stored
/// reference motion, and writes <output>/<body>/arena.h5. Under a ball that touches, methods that know no contact are
/// left out, which the notes say, and where no reference is stored there are forces and no errors.
/// @throws support::InputError for bad input, where no reference of a glued tool is stored, where a method that was
///         asked for knows no contact, and where a file cannot be written
ArenaResults run_arena(const ArenaOptions &options, const std::string &command_line, const ProgressReport &report);

/// Solves the reference motions of these bodies and stores them.
/// @return one of each body
/// @throws support::InputError also where the tool touches: no reference motion knows contact
std::vector<results::ToolReference> solve_arena_references(const ArenaOptions &options,
                                                           const ToolReferenceOptions &reference,
                                                           const std::string &command_line,
                                                           const ProgressReport &report);

} // namespace livermark::studies
