#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "studies/run/run_options.hpp"

/// Options that several commands have, with the same words.
namespace livermark::cli {

/// Bodies by name or path, after the command.
void add_bodies(CLI::App &command, std::vector<std::string> &bodies);

/// --young and --poisson
void add_materials(CLI::App &command, meshes::MaterialOverride &material);

/// --reference-on-mesh; its old name is refused.
void add_reference_on_mesh(CLI::App &command, bool &reference_on_mesh);

/// What to run, and how: --load-case, --regime, --model, --sweep, --poisson, --reference-on-mesh and --jobs
void add_run_choices(CLI::App &command, const std::shared_ptr<studies::RunOptions> &options);

/// In ascending order, each once.
std::vector<double> sorted_once(std::vector<double> values);

} // namespace livermark::cli
