#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "msm/engine_parameters.hpp"
#include "results/records/engine_entry.hpp"

namespace livermark::studies {

/// Folder of the entries of engines that were run, below the root.
inline constexpr const char *engines_folder = "results/engines";

/// Parameters of an engine for a body.
struct EngineSpringsOptions {
    std::string body;
    std::string engine; ///< of msm::all_engines()
    meshes::MaterialOverride material{};
    msm::EngineChoices choices{};
    std::string output = "."; ///< folder for <body>.<engine>.json and what else the engine reads
};

/// Errors that an engine has in some problems, as parts of one; NaN where none is known.
struct ErrorRange {
    static constexpr double nan = std::numeric_limits<double>::quiet_NaN();

    double median = nan;    ///< of absolute values
    double worst = nan;     ///< the one of the largest absolute value, with its sign
    std::size_t number = 0; ///< of problems in which it is known
};

/// Errors of an engine that was run.
struct EngineErrors {
    std::string version, machine;
    std::string settings;         ///< in one line, "substeps = 20"
    ErrorRange relative_l2;       ///< at rest, of the displacement of the whole body
    ErrorRange stiffness_at_tool; ///< at rest; positive: too stiff
    ErrorRange in_contact, force; ///< in motion, of the displacement and of the force on the tool
    std::size_t num_problems = 0;
    std::size_t num_failed = 0; ///< of these without a score
};

EngineErrors errors_of(const results::EngineEntry &entry);

/// Errors of the entry of an engine in results/engines; nothing where it was not run.
/// @throws support::InputError if its file is damaged
std::optional<EngineErrors> measured_errors(const std::string &engine);

/// Files that were written, and notes on the input.
struct EngineSprings {
    std::string body;
    msm::EngineParameters parameters;
    std::optional<EngineErrors> errors; ///< nothing where the engine was not run
    std::vector<std::filesystem::path> files;
    std::vector<std::string> notes;
};

/// Writes <output>/<body>.<engine>.json, and the text of the engine beside it where it has one.
/// @param command_line  kept in the file
/// @throws support::InputError for bad input, and where a file cannot be written
EngineSprings write_engine_springs(const EngineSpringsOptions &options, const std::string &command_line);

/// The file: an object with body, engine, provenance, settings (name, value, unit, meaning), arrays (by name: unit,
/// meaning, shape, values), notes, cannot, and errors or null. SI units; "" is the unit of what has none.
std::string engine_springs_text(const EngineSprings &springs, const std::string &command_line);

} // namespace livermark::studies
