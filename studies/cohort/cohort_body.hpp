#pragma once

#include <filesystem>

#include "meshes/generators/liver/liver_variation.hpp"
#include "results/hdf5/files/cohort_file.hpp"

namespace livermark::studies {

/// The body file of one body of a cohort, <folder>/liver_variant_<number>.toml.
std::filesystem::path cohort_body_file(const std::filesystem::path &folder, int number);

/// Says whether a body file that is there was made by the same number and options. One that is not TOML passes: reading
/// the body says what is wrong with it.
/// @throws support::InputError if it was made otherwise
void check_cohort_body(const std::filesystem::path &file, int number, int tetrahedra);

/// Makes the body if its file is not there; else it stays as it is, so that materials put into it stay too.
/// @param file  of cohort_body_file(), in a folder that exists
/// @throws support::InputError, std::runtime_error as meshes::generate_liver() and write_liver_body()
void make_cohort_body(const std::filesystem::path &file, const meshes::LiverVariant &variant, int tetrahedra);

/// What was drawn, as a cohort file has it.
results::CohortBody drawn_body(const meshes::LiverVariant &variant);

} // namespace livermark::studies
