#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/tool/tool_motion.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Outcome of a method within a budget.
enum class ArenaOutcome {
    ok,
    too_slow, ///< its least work takes longer than the budget; its errors are those of that work
    diverged  ///< left all bounds, or let a ball through its surface; its errors are NaN
};
const char *to_string(ArenaOutcome outcome);

/// A method on a mesh within a budget.
struct ArenaRun {
    std::string method;
    std::string setting; ///< how it uses its time
    int tetrahedra = 0;  ///< of the mesh
    double budget = 0.0; ///< of one core, for a frame [s]
    int steps = 0;       ///< in a frame
    int iterations = 0;  ///< in a step
    /// 1 where iterations are a limit: the method takes fewer, because nothing is left to do, and leaves time.
    int stops_early = 0;
    ArenaOutcome outcome = ArenaOutcome::ok;
    core::ToolErrors errors;
    double volume_error = 0.0;      ///< largest |v - v_r| / V of the whole body, over the fields
    double smallest_jacobian = 0.0; ///< of all tetrahedra, over the fields
    int num_inverted = 0;           ///< tetrahedra at the worst field
    double frame_seconds = 0.0;     ///< of the processor, median over frames [s]
    double frame_seconds_95 = 0.0;  ///< 95th percentile [s]
    double worst_frame_seconds = 0.0;
    double setup_seconds = 0.0;   ///< before the first frame
    double release_seconds = 0.0; ///< to prepare for the place being free
    double element_passes = 0.0;  ///< in a frame
    double bytes_per_element = 0.0;
    /// Difference of the times by which its effort was found, as a part of them; zero where it has no choice.
    double calibration_spread = 0.0;
    std::vector<core::Vector3> force; ///< (K) of the body on the tool [N]
    double pressed_force = 0.0;       ///< size of the force when the slide begins [N]
    double slid_force = 0.0;          ///< along the press of the tool, mean over the records within the slide [N]
    double slid_ratio = 0.0;          ///< the same across it, along the slide, over that along the press
    /// Largest depth by which the surface was inside a ball that touches at a record [m]: nodes are not, but facets
    /// between them are.
    double deepest = 0.0;

    bool operator==(const ArenaRun &) const = default;
};

/// Description of a method beside its runs.
struct ArenaMethod {
    std::string name;
    std::string source;         ///< literature reference
    std::string implementation; ///< how good it is, and its number format
    std::string converges_to;   ///< what its steps come to
    std::string objection;      ///< what users or authors object to, with sources

    bool operator==(const ArenaMethod &) const = default;
};

/// "12", or "up to 11547" where that is a limit.
std::string iterations_of(int iterations, int stops_early);

/// Spread above which the times of a calibration differ too much: its effort says something of the machine.
inline constexpr double largest_calibration_spread = 0.05;

/// Ways of the tool to move the body. The words are those of tables and files.
inline constexpr const char *glued_tool = "glued";       ///< it has hold of the nodes of a place
inline constexpr const char *touching_tool = "touching"; ///< it is a ball or a plate that touches and does not stick

/// All that is known about methods under one moving tool: the content of one arena file.
struct Arena {
    Provenance provenance;
    std::string body, load_case, title;
    std::string tool = glued_tool;              ///< or touching_tool: one for all runs
    double friction = 0.0;                      ///< of a tool that touches
    double ball_radius = 0.0;                   ///< of a ball that touches, or of the edges of a plate [m]
    core::ToolFace face = core::ToolFace::ball; ///< of a tool that touches
    double plate_size = 0.0;                    ///< of a plate, see core::ToolShape [m]
    /// The model that everything is compared with; empty if there is none, and errors and its force are NaN.
    std::string reference;
    double frame_interval = 0.0;                ///< [s]
    std::vector<double> time;                   ///< (K) of records [s]
    std::vector<core::Vector3> reference_force; ///< (K) [N]
    core::ToolErrors reference_errors;          ///< what the last refinement of the reference changed
    double reference_pressed_force = std::numeric_limits<double>::quiet_NaN(); ///< when the slide begins [N]
    std::vector<ArenaRun> runs;
    /// Runs with numbers of iterations or steps that were given, so that a method is seen to converge. They have no
    /// budget.
    std::vector<ArenaRun> series;
    std::vector<ArenaMethod> methods; ///< of these runs, each once
};

/// The "Arena files" of results/schema.md; errors as of write_result() and read_result().
void write_arena(const std::filesystem::path &path, const Arena &arena);
Arena read_arena(const std::filesystem::path &path);

/// A row for each method, setting and budget, mesh by mesh and the best of the contact errors first.
/// "-" where a program that moved by itself does not say it.
Layout arena_table(const Arena &arena);

/// Meaning of its columns.
std::string arena_legend();

/// A row for each method and mesh: the error in contact within each budget, of the best setting, and the least time
/// of a frame within which it was 20, 10 and 5 %.
Layout arena_overview(const Arena &arena);

/// Meaning of its columns.
std::string overview_legend();

/// The same with the forces on the tool in place of errors, where there is no reference: mesh by mesh.
Layout arena_forces(const Arena &arena);

/// A row for each run with given iterations, method by method: errors, and by how much the force when the slide begins
/// is above that of the reference, which is the stiffness at the tool that the method has with so many.
Layout arena_series(const Arena &arena);

/// A sentence on the tool, for the head of a table.
std::string tool_of(const Arena &arena);

/// A sentence on methods whose effort was found on a busy machine; empty if there are none.
std::string calibration_note(const Arena &arena);

} // namespace livermark::results
