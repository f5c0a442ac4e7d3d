#pragma once

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Kinds of problems of an engine. The words are those of files.
inline constexpr const char *at_rest = "rest";     ///< displacements of one moment
inline constexpr const char *in_motion = "motion"; ///< displacements and forces over time, under a moving tool

/// Outcomes of a problem of an engine.
inline constexpr const char *scored_outcome = "ok";
inline constexpr const char *cannot_outcome = "cannot"; ///< the engine has no solution, as its maker says
inline constexpr const char *failed_outcome = "failed"; ///< the solution could not be compared

/// Errors and cost of an engine in one problem. Errors are fractions, not percent; NaN is not known or of no meaning.
struct EngineProblem {
    static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

    std::string body{}, load_case{};
    std::string kind = at_rest;
    std::string regime{};               ///< `small` or `large`; empty where it failed before it was read
    int variant = 0;                    ///< number of a drawn liver, as for `livermark mesh liver`; 0 of another body
    int target_tetrahedra = 0;          ///< that it was drawn with
    int tetrahedra = 0;                 ///< of the mesh
    std::string digest{};               ///< fingerprint() of the problem; empty where it failed before
    double relative_l2 = unknown;       ///< at rest, see "Comparisons" of results/schema.md
    double stiffness_at_tool = unknown; ///< at rest, signed: positive is too stiff
    double in_contact = unknown;        ///< in motion, of displacements while the tool has hold of the body
    double force = unknown;             ///< in motion, of the force on the tool
    std::string reference{};            ///< the model that it is compared with
    double reference_error = unknown;   ///< of the reference, in the norm of relative_l2 or in_contact
    double seconds_per_frame = unknown; ///< as the maker of the solution says, like the next two [s]
    double setup_seconds = unknown;     ///< before the first frame, or the whole solution at rest [s]
    double memory_bytes = unknown;      ///< of the process, at most [bytes]
    std::string outcome = scored_outcome;
    std::string message{}; ///< why it is not ok; empty otherwise

    bool is_scored() const { return outcome == scored_outcome; }
    bool has_failed() const { return outcome == failed_outcome; }
};

/// An engine with the problems that it solved: the content of one file of results/engines/.
struct EngineEntry {
    std::string engine{};              ///< name, which is the stem of the file
    std::string version{};             ///< of the engine
    std::string url{};                 ///< where it comes from; may be empty
    std::string machine{};             ///< what it ran on
    std::string notes{};               ///< may be empty
    int board = 0;                     ///< seed of the board whose livers all variants are; 0 where they are of none
    std::vector<std::string> cannot{}; ///< what it cannot do, a sentence each
    nlohmann::ordered_json settings = nlohmann::ordered_json::object(); ///< of the engine, free
    std::string livermark{};                                            ///< version of the program that scored it
    std::string git_commit{};                                           ///< of that program
    std::string created{};                                              ///< ISO 8601, UTC
    std::vector<EngineProblem> problems{};
};

/// The "Engine files" of results/schema.md as text: JSON, with null for what is NaN.
std::string engine_entry_text(const EngineEntry &entry);

/// The entry of such a text. Keys that are missing or null are unknown numbers or empty texts, except the names of
/// engine, version, body and load case.
/// @param file  named in messages
/// @throws support::InputError for what is not JSON, for unknown keys, and for values of another type
EngineEntry parse_engine_entry(const std::string &text, const std::string &file);

/// Writes such a file.
/// @throws support::InputError if the place cannot be written to
void write_engine_entry(const std::filesystem::path &path, const EngineEntry &entry);

/// Reads such a file.
/// @throws support::InputError as parse_engine_entry(), and if the file cannot be read
EngineEntry read_engine_entry(const std::filesystem::path &path);

/// A row for each problem. "-" for what is not known.
Layout engine_entry_table(const EngineEntry &entry);

/// Meaning of its columns.
std::string engine_entry_legend();

} // namespace livermark::results
