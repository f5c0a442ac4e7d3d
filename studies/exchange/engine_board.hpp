#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/records/engine_entry.hpp"
#include "studies/exchange/exchange.hpp"
#include "studies/study.hpp"

/// Problems that engines take part with, and what they write of their solutions.
namespace livermark::studies {

/// A problem of an entry file, and where its solution is.
struct EntryProblem {
    std::string body;          ///< a name, or a path; empty of a drawn liver
    int variant = 0;           ///< of a drawn liver, as for `livermark mesh liver`; 0 of another body
    int target_tetrahedra = 0; ///< of a drawn liver; 0: as many as the livers that ship have
    std::string load_case;     ///< a name, or a path
    std::string solution;      ///< path of a file for `livermark score`; empty where the engine has none
    std::string unit;          ///< of the displacements, as ScoreOptions has it
    std::string cannot;        ///< why the engine has no solution; empty where it has one
    double seconds_per_frame = results::EngineProblem::unknown; ///< [s]
    double setup_seconds = results::EngineProblem::unknown;     ///< [s]
    double memory_bytes = results::EngineProblem::unknown;      ///< [bytes]
};

/// Content of an entry file: its engine, without scores, and its problems, at least one.
struct EntryFile {
    results::EngineEntry entry;
    std::vector<EntryProblem> problems;
};

/// Parses an entry file: TOML with the keys engine, version, machine, and url, notes, cannot (a list of sentences),
/// board (the seed of its livers), [settings] (free), which may be left out; and of each [[problem]] either body, or
/// variant with tetrahedra, its load_case, and either solution or cannot (why there is none); unit, seconds_per_frame,
/// setup_seconds and memory_bytes may be left out.
/// @param file  named in messages; paths of solutions, bodies and load cases are relative to its folder
/// @throws support::InputError with file, line and remedy
EntryFile parse_entry_file(const std::string &text, const std::filesystem::path &file);

/// Options of `livermark score --entry`.
struct EntryOptions {
    std::string entry;  ///< an entry file
    std::string output; ///< folder; if it is empty the entry goes beside the entry file, results into results/scores
    std::vector<std::string> models{models::baseline_name()}; ///< see ScoreOptions, like the next two
    bool reference_on_mesh = false;
    bool solve_reference = false;
};

/// The entry of an engine with its scores, the file that it is in, and what a user should know of the input.
struct ScoredEntry {
    results::EngineEntry entry;
    std::filesystem::path file;
    std::vector<std::string> notes;
};

/// Scores each problem of an entry file as score() and score_motion() do, and writes <engine>.json. A problem that
/// fails does not stop the others: its outcome and its message say so. Drawn livers are drawn again here.
/// @param command_line  kept in the result files
/// @throws support::InputError for bad input, and where the file cannot be written
ScoredEntry score_entry(const EntryOptions &options, const std::string &command_line, const ProgressReport &report);

/// Numbers of the two livers of a board. They are even, the half that no model was tuned on, and above 1000, beyond the
/// cohorts that ship.
/// @param seed  from 1
std::vector<int> board_livers(int seed);

/// Draws the livers of a board, of about 4,000 tetrahedra, as <output>/bodies/liver_variant_<number>.toml, writes their
/// problems as export_problem() does, at rest and in motion, under small loads and large ones, and <output>/entry.toml,
/// an entry file that waits for their solutions. Bodies that are there are kept.
/// @param seed  from 1
/// @param options  output, formats and choices; body and load case are those of the board
/// @param command_line  kept in the files
/// @throws support::InputError where a file cannot be written, and if there is an entry.toml
ExportedProblem export_board(int seed, const ExportOptions &options, const std::string &command_line,
                             const ProgressReport &report);

} // namespace livermark::studies
