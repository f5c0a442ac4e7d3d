#pragma once

#include <span>
#include <string>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "results/hdf5/described.hpp"
#include "results/hdf5/hdf5_io.hpp"
#include "results/records/result.hpp"

/// The group /load_case of a result file. Internal to results/.
namespace livermark::results::hdf5 {

void write_load_case(OutputFile &file, const core::LoadCase &load_case);

/// @param num_triangles, num_nodes  of the mesh that it was put on
/// @throws support::InputError for sizes, indices and values that no load case on that mesh has
core::LoadCase read_load_case(const InputFile &file, std::size_t num_triangles, std::size_t num_nodes);

} // namespace livermark::results::hdf5

/// Groups of a result file, and the names that its writer and its reader share. Internal to results/.
namespace livermark::results {

/// The model in a file of a single solution, see write_solution().
inline const std::string only_solution = "only";
inline std::string solution_group(const std::string &model) {
    return "/solutions/" + model;
}
inline std::string comparison_group(const std::string &model) {
    return "/comparisons/" + model;
}

/// Springs of a model in a file.
struct NamedSprings {
    std::string group; ///< of the model in the file
    const core::SpringNetwork *springs;
};

/// Writes the springs of a model; fields that one of the earlier models has get a second name.
void write_springs(hdf5::OutputFile &file, const NamedSprings &model, std::span<const NamedSprings> earlier);

/// Writes /solutions/<model>, all but the springs.
void write_solution_group(hdf5::OutputFile &file, const std::string &model, const core::Solution &solution,
                          const core::LoadCase &load_case);

/// Reads /solutions/<model> with its springs.
/// @throws support::InputError for what the schema does not allow
core::Solution read_solution_group(const hdf5::InputFile &file, const std::string &model, const core::Problem &problem);

/// Frames of a motion times nodes.
std::size_t num_frame_rows(const core::Problem &problem);

/// Writes /load_case/tool, which the mesh and the load case decide; nothing where the load case has no tool.
void write_tools(hdf5::OutputFile &file, const core::Problem &problem);

/// Writes /comparisons/<model>/tool and its attributes.
/// @param at  /comparisons/<model>
void write_tool_comparison(const hdf5::GroupWriter &at, const core::ToolComparison &tool,
                           const core::LoadCase &load_case);

/// Reads /comparisons/<model>/tool; what its attributes say follows from it.
/// @throws support::InputError for what the schema does not allow
core::ToolComparison read_tool_comparison(const hdf5::GroupReader &at, const core::LoadCase &load_case);

/// Adds the group /VTKHDF, in which ParaView and VTK (>= 9.1) see the file as an unstructured grid with the
/// displacement and the error of every model. Where models moved, ParaView >= 5.12 and VTK >= 9.3 see the frames of
/// their motion as steps in time, and older ones the first. Points and fields are hard links to the datasets that are
/// in the file already. Format: https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/index.html, version
/// 1.0, with steps 2.0
void write_vtkhdf(hdf5::OutputFile &file, const Result &result);

} // namespace livermark::results
