#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "meshes/body_reader.hpp"

/// Options that several commands have, with the same words.
namespace livermark::cli {

/// Bodies by name or path, after the command.
void add_bodies(CLI::App &command, std::vector<std::string> &bodies);

/// --young and --poisson
void add_materials(CLI::App &command, meshes::MaterialOverride &material);

} // namespace livermark::cli
