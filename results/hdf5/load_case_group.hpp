#pragma once

#include <cstddef>

#include "core/load_case.hpp"
#include "results/hdf5/io/hdf5_io.hpp"

/// The group /load_case of a result file. Internal to results/.
namespace livermark::results::hdf5 {

void write_load_case(OutputFile &file, const core::LoadCase &load_case);

/// @param num_triangles, num_nodes  of the mesh that it was put on
/// @throws support::InputError for sizes, indices and values that no load case on that mesh has
core::LoadCase read_load_case(const InputFile &file, std::size_t num_triangles, std::size_t num_nodes);

} // namespace livermark::results::hdf5
