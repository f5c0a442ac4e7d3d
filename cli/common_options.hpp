#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "studies/run/run.hpp"

/// Options that several commands have, with the same words.
namespace livermark::cli {

/// Bodies behind the command or behind --body, which is the same everywhere.
/// @param which  the end of the help: how many, or what happens where none is named
CLI::Option *add_bodies(CLI::App &command, std::vector<std::string> &bodies,
                        const std::string &which = "by default all that ship");

/// One body, in the same two ways.
CLI::Option *add_body(CLI::App &command, std::string &body);

/// --load-case of a command that takes constraints alone.
void add_constraints(CLI::App &command, std::string &load_case);

/// --young and --poisson
void add_materials(CLI::App &command, meshes::MaterialOverride &material);

/// --reference-on-mesh; its old name is refused.
void add_reference_on_mesh(CLI::App &command, bool &reference_on_mesh);

/// What to run, and how: --load-case, --regime, --model, --sweep, --poisson, --reference-on-mesh and --jobs
void add_run_choices(CLI::App &command, const std::shared_ptr<studies::RunOptions> &options);

/// In ascending order, each once.
std::vector<double> sorted_once(std::vector<double> values);

/// Lets an option be a regime.
CLI::Validator a_regime();

} // namespace livermark::cli
