#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "meshes/generators/liver_shape.hpp"
#include "results/records/cohort.hpp"
#include "studies/run/run.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

/// Numbers that bodies of a cohort are drawn by, from a list of numbers and ranges such as "1-8,12".
/// @return ascending, at least one
/// @throws support::InputError for anything else, for a number that is there twice, and for more than a thousand
std::vector<int> body_numbers(const std::string &text);

/// The body file of a drawn liver, <folder>/liver_variant_<number>.toml.
std::filesystem::path cohort_body_file(const std::filesystem::path &folder, int number);

/// Refuses a body file that is there and was not made by the same number and options. One that is not TOML passes:
/// reading the body says what is wrong with it.
/// @throws support::InputError if it was made otherwise
void check_cohort_body(const std::filesystem::path &file, int number, int tetrahedra);

/// Makes the body if its file is not there; else it stays as it is, so that materials put into it stay too.
/// @param file  of cohort_body_file(), in a folder that exists
/// @throws support::InputError, std::runtime_error as meshes::generate_liver() and write_liver_body()
void make_cohort_body(const std::filesystem::path &file, const meshes::LiverVariant &variant, int tetrahedra);

/// Options of `livermark cohort`.
struct CohortOptions {
    std::vector<int> bodies; ///< of body_numbers()
    int tetrahedra = 0;      ///< of each, about; 0: as many as the bodies that ship have
    /// Models, load cases, regimes, Poisson's ratios, workers and the output folder; the rest is set here.
    RunOptions run;
};

/// Load cases of one body that were not evaluated again.
struct KeptResults {
    std::string body;
    int num_kept, num_load_cases;
};

struct CohortOutcome {
    results::Cohort cohort;
    std::vector<KeptResults> kept;  ///< bodies that have some
    std::vector<std::string> notes; ///< what a user should know of the bodies, a sentence each
    TimeSpent spent;
    bool is_well = true; ///< nothing failed, and every model has come to an end that has to
};

/// Makes the livers of other people, <output>/bodies/liver_variant_<number>.toml, lets the models solve the static load
/// cases on them, <output>/<body>/<load case>.h5 as in a run, and writes <output>/cohort.h5. Bodies and results that
/// are there already, made by the same options and program, are kept. A body or load case that fails does not stop the
/// others.
/// @param command_line  kept in cohort.h5; result files have the `livermark run` that makes them in the output folder
/// @throws support::InputError for bad input, with nothing written, and if a result cannot be kept
CohortOutcome run_cohort(const CohortOptions &options, const std::string &command_line, const ProgressReport &report);

} // namespace livermark::studies
