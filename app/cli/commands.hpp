#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "results/records/cohort.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"
#include "studies/run/run.hpp"
#include "studies/study.hpp"

namespace livermark::cli {

/// A subcommand adds itself, with its options, to the command line and returns what to do when it was asked for.
/// That returns the exit status: 0 all done, 1 a run failed. Bad input is a support::InputError.
using Command = std::function<int()>;

Command add_list(CLI::App &parent);
Command add_table(CLI::App &parent);
Command add_view(CLI::App &parent);
/// @param command_line  kept in the result files
Command add_mesh(CLI::App &parent, const std::string &command_line);
Command add_advise(CLI::App &parent, const std::string &command_line);
Command add_arena(CLI::App &parent, const std::string &command_line);
Command add_cohort(CLI::App &parent, const std::string &command_line);
Command add_modes(CLI::App &parent, const std::string &command_line);
Command add_needle(CLI::App &parent, const std::string &command_line);
Command add_cut(CLI::App &parent, const std::string &command_line);
Command add_experiment(CLI::App &parent, const std::string &command_line);
Command add_export(CLI::App &parent, const std::string &command_line);
Command add_score(CLI::App &parent, const std::string &command_line);
Command add_reference(CLI::App &parent, const std::string &command_line);
Command add_run(CLI::App &parent, const std::string &command_line);
Command add_report(CLI::App &parent, const std::string &command_line);
Command add_sensitivity(CLI::App &parent, const std::string &command_line);
Command add_springs(CLI::App &parent, const std::string &command_line);
Command add_stability(CLI::App &parent, const std::string &command_line);

/// Faults of the command line as one sentence with the remedy, where CLI11 would take several lines, show numbers of
/// its own or name the largest double in full. Options that several commands have, with the same words.

/// Refuses a word in the place of a subcommand that is none, and names the nearest one.
/// @throws support::InputError
void refuse_unknown_subcommand(const CLI::App &app, const std::vector<std::string> &words);

/// Lets the help describe an argument once that is also an option, such as body and --body. Subcommands that are added
/// later inherit it.
void describe_arguments_once(CLI::App &app);

/// Lets every option that names a place to write to, such as --output, refuse an empty name. Called when all commands
/// are there.
void refuse_empty_places(CLI::App &app);

/// The sentence for a command line that CLI11 has refused.
std::string usage_sentence(const CLI::App &app, const CLI::ParseError &error);

/// Checks for options that take numbers.
CLI::Validator positive_number();
CLI::Validator number_not_below_zero();

/// Lets an option be one of some words.
/// @param known  in lower case
CLI::Validator one_of(const std::vector<std::string> &known);

/// The same for an option that is an enumeration: word by word, what it stands for.
template <class Enumeration> CLI::Validator one_of(const std::map<std::string, Enumeration> &values) {
    std::vector<std::string> known;
    std::map<std::string, std::string> number_of;
    for (const auto &[word, value] : values) {
        known.push_back(word);
        number_of[word] = std::to_string(static_cast<int>(value));
    }
    auto validator = one_of(known);
    const auto check = validator;
    return validator.operation([=](std::string &text) {
        auto fault = check(text);
        if (fault.empty())
            text = number_of.at(CLI::detail::to_lower(text));
        return fault;
    });
}

/// Bodies behind the command or behind --body, which is the same everywhere.
/// @param which  the end of the help: how many, or what happens where none is named
CLI::Option *add_bodies(CLI::App &command, std::vector<std::string> &bodies,
                        const std::string &which = "by default all that ship");

/// One body, in the same two ways.
CLI::Option *add_body(CLI::App &command, std::string &body);

/// --load-case of a command that takes constraints alone.
void add_constraints(CLI::App &command, std::string &load_case);

/// --output, a folder below results/ where none is named.
CLI::Option *add_output(CLI::App &command, std::string &output, const std::string &help, const char *folder = "runs");

/// --data, a folder of public data.
CLI::Option *add_data(CLI::App &command, std::string &data);

/// @param data  as --data gave it, empty where it did not
/// @throws support::InputError if it is no folder
void refuse_no_folder(const std::string &data);

/// results/runs, where commands have their files unless they are told otherwise.
std::string runs_folder();

/// --young and --poisson
void add_materials(CLI::App &command, meshes::MaterialOverride &material);

/// --reference-on-mesh; its old name is refused.
void add_reference_on_mesh(CLI::App &command, bool &reference_on_mesh);

/// Choices of a run: --load-case, --regime, --model, --sweep, --poisson, --reference-on-mesh and --jobs
void add_run_choices(CLI::App &command, const std::shared_ptr<studies::RunOptions> &options);

/// In ascending order, each once.
std::vector<double> sorted_once(std::vector<double> values);

/// Lets an option be a regime.
CLI::Validator a_regime();

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
