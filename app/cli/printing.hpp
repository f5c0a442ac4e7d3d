#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "results/records/cohort.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/study.hpp"

namespace livermark::cli {

/// Says on standard error how far long work is: on a terminal a line that is overwritten, and erased with the last copy
/// of what this returns; elsewhere a plain line for each step.
studies::ProgressReport print_progress();

/// A table as text, or in Markdown.
std::string table_text(const results::Layout &layout, bool markdown);

/// Says on standard error what a user should know of the input, a line for each sentence.
void print_notes(const std::vector<std::string> &notes);

enum class TableKind { brief, all, models, forces, summary, overview, means, medians, cohort };

/// By their words on the command line.
inline const std::map<std::string, TableKind> table_kinds{
    {"brief", TableKind::brief},   {"all", TableKind::all},         {"models", TableKind::models},
    {"forces", TableKind::forces}, {"summary", TableKind::summary}, {"overview", TableKind::overview},
    {"means", TableKind::means},   {"medians", TableKind::medians}, {"cohort", TableKind::cohort}};

/// Prints what results say, to standard output: a row for each model, the summary by load case, the overview by
/// Poisson's ratio if a body is there with several of them, and the medians over load cases if a body has several of
/// these. The brief table has two numbers for each model and body; where nothing at rest is to be compared all tables
/// take its place. Each kind is also printed when it is asked for; the means over load cases by body, the forces along
/// the paths of large deformations and the statistics over a cohort of bodies, only then. Small and large deformations
/// are never in one table, nor are errors against different references: each group has its tables, below a sentence
/// that names the reference. Nothing is printed where there are no results.
/// @throws support::InputError if medians are asked for and there is no static load case, and if a cohort is asked for
///   and no body's name ends in a number
void print_tables(std::span<const results::Result> results, TableKind kind, bool markdown);

/// Prints statistics of errors, as `--kind cohort` does; Python makes them.
/// @throws support::InputError if there are none, and where numpy or h5py is missing
void print_cohort(std::span<const results::CohortError> errors, bool markdown);

} // namespace livermark::cli
