#pragma once

#include <span>
#include <string>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "results/hdf5/io/hdf5_io.hpp"

namespace livermark::results {

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

} // namespace livermark::results
