#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"
#include "core/tool/tool_motion.hpp"
#include "results/records/result.hpp"

namespace livermark::results {

/// Kinds of conditions on a facet, as result files number them.
enum FacetCode : std::uint8_t { free_facet, prescribed_facet, traction_facet };

/// The conditions of a load case as one row for each facet: what result files hold, and keys of problems are made of.
struct FacetArrays {
    std::vector<std::uint8_t> condition; ///< (T) FacetCode
    std::vector<int> constraint;         ///< (T) index into constraint_names, -1 where the force is known
    std::vector<std::string> constraint_names;
    std::vector<int> load; ///< (T) index into load_names, -1 where no traction is given; empty where none has a name
    std::vector<std::string> load_names;
    std::vector<std::uint8_t> follows; ///< (T) 1 where a pressure follows the surface; empty where none does
    std::vector<int> round_load; ///< (T) index into round_loads, -1 where the traction is even; empty where all are
    std::vector<core::RoundLoad> round_loads;
};

FacetArrays facet_arrays(const core::LoadCase &load_case);

/// Sixteen digits that stand for all that a solution depends on beside the model: mesh, materials, conditions, loads,
/// path, release, and the names and the definition that it is kept with. Every bit counts. It is the same after a
/// result file was written and read.
std::string problem_key(const core::Problem &problem);

/// Sixteen digits that stand for all that a solution depends on: model, mesh, materials, conditions, path, release.
/// Numbers count with nine digits, so that machines that round differently agree.
std::string fingerprint(const core::Problem &problem, const std::string &model);

/// Place of the stored solution of a model to a problem: <folder>/<body>/<load case>.<model>.<fingerprint()>.h5.
std::filesystem::path reference_path(const std::filesystem::path &folder, const core::Problem &problem,
                                     const std::string &model);

/// Writes a solution with its fingerprint, the model's name and where it comes from; of a motion the probes and not the
/// frames.
/// @throws support::InputError if the place cannot be written to
void write_reference(const std::filesystem::path &path, const core::Solution &solution, const core::Problem &problem,
                     const std::string &model, const Provenance &provenance);

/// Reads what write_reference wrote. The solver of the solution says that it was stored, since when and of which
/// commit.
/// @return nothing if there is no such file, or if it is of something else
/// @throws support::InputError if it is damaged
std::optional<core::Solution> read_reference(const std::filesystem::path &path, const core::Problem &problem,
                                             const std::string &model);

/// The motion that others under a tool are compared with.
struct ToolReference {
    std::string model;
    int level = 0; ///< of refinement
    int steps_per_frame = 0;
    core::ToolHistory history;
    core::ToolErrors last_refinement; ///< of the motion before the last refinement, from this one
    core::ToolErrors half_steps;      ///< of the motion with half as many steps, on the mesh as it is
};

/// Writes it with its fingerprint() and where it comes from.
/// @throws support::InputError if the place cannot be written to
void write_tool_reference(const std::filesystem::path &path, const ToolReference &reference,
                          const core::Problem &problem, const Provenance &provenance);

/// @return nothing if there is no such file, or if it is of something else
/// @throws support::InputError if it is damaged
std::optional<ToolReference> read_tool_reference(const std::filesystem::path &path, const core::Problem &problem,
                                                 const std::string &model);

/// Nodes that a tool moves, and where to.
struct ToolNodes {
    std::vector<int> held;                   ///< (H) nodes that never move
    std::vector<int> nodes;                  ///< (T) that the tool has hold of
    std::vector<core::Vector3> displacement; ///< (K, T) of these at each record [m]; of no meaning once it has let go
};

/// Writes the "tool scenes" of results/schema.md: all that a program of somebody else needs to move a body.
/// @param problem  of a load case with a tool
/// @throws support::InputError if the place cannot be written to
void write_tool_scene(const std::filesystem::path &path, const core::Problem &problem, const ToolNodes &tool,
                      const Provenance &provenance);

/// A motion that somebody else has found for such a scene.
struct OutsideMotion {
    core::ToolHistory history;
    double seconds_per_frame = 0.0; ///< as its maker says; NaN if nothing is said
};

/// Reads HDF5 with the datasets displacement, (K, N, 3) of all records or (F, N, 3) of every fourth [m], and force,
/// (K, 3) of the body on the tool [N], and the attribute seconds_per_frame of the root, which may be left out.
/// @throws support::InputError that names the file and the dataset, and says what is wrong and what to do
OutsideMotion read_outside_motion(const std::filesystem::path &path, const core::Problem &problem);

} // namespace livermark::results
